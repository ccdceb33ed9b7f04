"""Numbers drawn by key and count: the published generator, and the statistics of what is made of it."""

import numpy as np
import pytest

from poinsot.random_numbers import UNUSED_BITS, key_of, normals, uniform, words

MASK = 2**64 - 1


def uniforms(keys, numbers, count):
    """Return independent numbers between 0 and 1: arrays of the shape of the keys."""
    found = words(keys, np.asarray(numbers).astype(np.int64).astype(np.uint64), count)
    return [uniform((word >> UNUSED_BITS).astype(float)) for word in found]


def split_mix(state, count):
    """SplitMix64 as published, on Python's integers."""
    found = []
    for _ in range(count):
        state = (state + 0x9E3779B97F4A7C15) & MASK
        z = ((state ^ (state >> 30)) * 0xBF58476D1CE4E5B9) & MASK
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK
        found.append(z ^ (z >> 31))
    return found


def test_the_generator_is_the_published_one():
    assert split_mix(0, 3) == [0xE220A8397B1DCDAF, 0x6E789E6AA1B965F4, 0x06C45D188009454F]
    # The key of seed 0 and member 0 starts from the first word of a generator at state 0.
    (key,) = key_of(0.0, 0)
    assert int(key) == split_mix(0, 1)[0]
    (first,) = split_mix((int(key) + 4 * 0x9E3779B97F4A7C15 - 0x9E3779B97F4A7C15) & MASK, 1)
    found = words(key_of(0.0, 0), np.array([4], np.uint64), 3)
    assert [int(word[0]) for word in found] == split_mix(first, 3)


@pytest.mark.parametrize("seed", [0.0, 7.0, 2.0**52])
def test_normal_numbers_have_the_moments_of_their_distribution(seed):
    count = 40_000
    keys = np.repeat(key_of(seed, 3), count)
    found = np.array(normals(uniforms(keys, np.arange(count), 6)))
    n = found.size
    assert abs(found.mean()) < 4 / np.sqrt(n)
    for power, moment, variance in ((2, 1, 2), (3, 0, 15), (4, 3, 96)):
        assert abs(np.mean(found**power) - moment) < 4 * np.sqrt(variance / n)
    assert np.max(np.abs(np.corrcoef(found) - np.eye(6))) < 4.5 / np.sqrt(count)
    following = np.sum(found[:, 1:] * found[:, :-1]) / n
    assert abs(following) < 4 / np.sqrt(n)


def test_members_seeds_and_samples_before_time_zero_have_numbers_of_their_own():
    keys = np.concatenate([key_of(seed, np.arange(50)) for seed in (0.0, 1.0, 2.0)])
    assert np.unique(keys).size == 150
    numbers = np.arange(-100.0, 100.0)
    (found,) = uniforms(np.repeat(keys[:1], 200), numbers, 1)
    assert np.unique(found).size == 200
    assert 0 < found.min() < 0.05
    assert 0.95 < found.max() < 1
    members = np.array(normals(uniforms(keys, np.zeros(150), 2)))
    assert abs(members.mean()) < 4 / np.sqrt(300)


def test_uniform_numbers_stay_between_zero_and_one():
    least, most = (uniform(float(word >> UNUSED_BITS)) for word in (0, MASK))
    assert least == 2.0**-53
    assert most == 1 - 2.0**-53
