"""Classes that are found by what they derive from."""

import abc

import poinsot as pt
from poinsot.subclasses import concrete, is_own, subclasses


class Base(abc.ABC):
    @abc.abstractmethod
    def act(self): ...


class Left(Base):
    def act(self):
        return 1


class Right(Base):
    def act(self):
        return 2


class Both(Left, Right):
    pass


def test_each_class_comes_once_and_the_base_too():
    assert sorted(cls.__name__ for cls in subclasses(Base)) == ["Base", "Both", "Left", "Right"]
    assert sorted(cls.__name__ for cls in subclasses(Left, Right)) == ["Both", "Left", "Right"]


def test_an_abstract_class_has_no_objects():
    assert set(concrete(Base)) == {Both, Left, Right}


def test_the_packages_own_are_known_from_others():
    assert is_own(pt.Body)
    assert is_own(pt.propagate)
    assert not is_own(Left)
