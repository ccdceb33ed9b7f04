"""Cycles of imports, imports that go up, and globals that a module leaves to other modules."""

import ast


def circles(edges):
    """Return the sets of modules that import one another, directly or by others: Tarjan's components."""
    order, low, stack, found = {}, {}, [], []

    def visit(node):
        order[node] = low[node] = len(order)
        stack.append(node)
        for other in sorted(edges[node]):
            if other not in order:
                visit(other)
            if other in stack:
                low[node] = min(low[node], low[other])
        if low[node] == order[node]:
            place = stack.index(node)
            found.append(sorted(stack[place:]))
            del stack[place:]

    for node in sorted(edges):
        if node not in order:
            visit(node)
    return [names for names in found if len(names) > 1]


def place_of(module, rows):
    places = [i for i, row in enumerate(rows) for name in row if f"{module}.".startswith(f"{name}.")]
    return places[0] if places else None


def upward(edges, rows):
    """Return the imports that go up, or across to another module of the layer."""
    found = []
    for name, others in edges.items():
        for other in others:
            here, there = place_of(name, rows), place_of(other, rows)
            if here is None or there is None:
                continue
            own = next(x for x in rows[here] if f"{name}.".startswith(f"{x}."))
            if there < here or (there == here and not f"{other}.".startswith(f"{own}.")):
                found.append(f"{name} -> {other}")
    return sorted(found)


def set_elsewhere(text):
    """Yield the globals that a module declares without a value, and the globals that it sets in another module."""
    tree = ast.parse(text)
    yield from (ast.unparse(node.target) for node in tree.body if isinstance(node, ast.AnnAssign) and not node.value)
    nodes = [*ast.walk(tree)]
    imported = {
        (alias.asname or alias.name).partition(".")[0]
        for node in nodes
        if isinstance(node, ast.Import | ast.ImportFrom)
        for alias in node.names
    }
    for node in nodes:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        for target in targets:
            name = ast.unparse(target) if isinstance(target, ast.Attribute) else ""
            if name.replace(".", "").isidentifier() and name.partition(".")[0] in imported:
                yield name
