"""Symbols of object code in the formats of Linux, macOS and Windows, read from their specifications."""

import struct


def undefined(content):
    """Return the names that object code takes from elsewhere; in Mach-O without their leading underscore."""
    for magic, read in ((b"\x7fELF", _elf), (b"\xcf\xfa\xed\xfe", _mach_o)):
        if content.startswith(magic):
            return read(content)
    return _coff(content)


def _text(content, start):
    return content[start : content.index(b"\0", start)].decode()


def _elf(content):
    """ELF-64: the section headers, of which one (type 2) is the table of symbols."""
    start, size, count = *struct.unpack_from("<Q", content, 40), *struct.unpack_from("<HH", content, 58)
    sections = [struct.unpack_from("<IIQQQQIIQQ", content, start + k * size) for k in range(count)]
    found = set()
    for _, kind, _, _, place, length, link, _, _, one in sections:
        if kind == 2:
            for at in range(place + one, place + length, one):
                name, _, _, section = struct.unpack_from("<IBBH", content, at)
                if section == 0:
                    found.add(_text(content, sections[link][4] + name))
    return found


def _mach_o(content):
    """Mach-O of 64 bits: the load commands, of which one (2) is the table of symbols."""
    count, at, found = struct.unpack_from("<I", content, 16)[0], 32, set()
    for _ in range(count):
        kind, size = struct.unpack_from("<II", content, at)
        if kind == 2:
            place, symbols, names, _ = struct.unpack_from("<IIII", content, at + 8)
            for k in range(symbols):
                name, what, *_ = struct.unpack_from("<IBBHQ", content, place + 16 * k)
                if what & 0x0E == 0 and what & 1:
                    found.add(_text(content, names + name).removeprefix("_"))
        at += size
    return found


def _coff(content):
    """COFF: the table of symbols, in which auxiliary records follow a symbol, and a table of longer names."""
    place, count = struct.unpack_from("<II", content, 8)
    names, found, k = place + 18 * count, set(), 0
    while k < count:
        short, _, section, _, storage, more = struct.unpack_from("<8sIhHBB", content, place + 18 * k)
        if section == 0 and storage == 2:
            zeros, offset = struct.unpack("<II", short)
            found.add(short.rstrip(b"\0").decode() if zeros else _text(content, names + offset))
        k += 1 + more
    return found
