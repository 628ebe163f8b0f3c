"""Every field of every Nastran card is used, told or refused; positions are those of pyNastran's attributes."""

import numpy as np
import pytest
from fem.card_fields import CARDS, written

from flexmb.errors import FlexmbError
from flexmb.fem.deck.nastran import read_nastran_deck

NAMES = sorted({card.name for card in CARDS if card.changes})
QUICK = ("CBUSH", "CONM2", "PBAR")
BY_NAME = [pytest.param(name, marks=[] if name in QUICK else pytest.mark.slow) for name in NAMES]


def plain(thing):
    """Return an object as nested tuples that compare by value."""
    if isinstance(thing, np.ndarray):
        return thing.shape, thing.tobytes()
    if isinstance(thing, list | tuple):
        return tuple(map(plain, thing))
    if isinstance(thing, set | frozenset):
        return tuple(sorted(map(str, thing)))
    if isinstance(thing, dict):
        return tuple((key, plain(value)) for key, value in thing.items())
    if hasattr(thing, "__dict__"):
        return tuple((key, plain(value)) for key, value in vars(thing).items())
    return repr(thing)


def described(tmp_path, text):
    """Return what a deck becomes, by field of `Deck`; the message if it is refused."""
    path = tmp_path / "cards.bdf"
    path.write_text(text)
    try:
        return {name: plain(value) for name, value in vars(read_nastran_deck(path)).items()}
    except FlexmbError as error:
        return str(error)


def test_the_deck_is_read(tmp_path):
    assert isinstance(described(tmp_path, written()), dict)


@pytest.mark.parametrize("name", BY_NAME)
def test_every_field_is_used_told_or_refused(tmp_path, name):
    before = described(tmp_path, written())
    unnoticed, acting = [], []
    for card in (card for card in CARDS if card.name == name):
        for position, attribute, value, acts in card.changes:
            after = described(tmp_path, written(card, position, value))
            if (after == before) is acts:
                (unnoticed if acts else acting).append(f"{position}:{attribute}")
    assert not unnoticed
    assert not acting  # a field that has an effect after all belongs among the others


def test_shear_factors_do_not_count_beside_i12(tmp_path):
    """PBAR: K1 and K2 are ignored where I12 is given (MSC Nastran Quick Reference Guide; pyNastran drops them too)."""
    card = next(card for card in CARDS if card.name == "PBAR" and card.fields[0] == "7")
    before = described(tmp_path, written())
    assert described(tmp_path, written(card, 17, ".5")) == before
    assert described(tmp_path, written(card, 19, "0.")) != before


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("CBAR,120,7,21,22,.1,1.,.2,GGG", "CBAR,120,7,21,22,.1,1.,.2,GEG", "OFFT = GEG"),
        (
            "GGG,+\n+,4,56,.01,.02,.03,.04,.05,.06\nCBAR,121",
            "GGG,+\n+,47,56,.01,.02,.03,.04,.05,.06\nCBAR,121",
            "digits",
        ),
        ("CBEAM,122,10,23,24,.1,1.,.2,GGG", "CBEAM,122,10,23,24,.1,1.,.2,1.5", "BIT"),
        ("PBUSH1D,26,3.+6", "PBUSH1D,26,3.+6,,,,,,,+\n+,SPRING,TABLE,5", "PBUSH1D: a table"),
        ("PSHELL,1,1,.01,3", "PSHELL,1,1,.01,-1", "plane strain"),
        ("PARAM,COUPMASS,1", "CTRIAX6,900,1,1,2,3,4,5,6", "CTRIAX6: an element of axisymmetric"),
    ],
)
def test_values_that_are_not_read_are_named(tmp_path, old, new, told):
    assert written().count(old) == 1
    assert told in str(described(tmp_path, written().replace(old, new)))


@pytest.mark.peer
@pytest.mark.parametrize("name", NAMES)
def test_positions_are_those_of_pynastran(name):
    """A changed field changes the attribute of pyNastran by that name."""
    bdf = pytest.importorskip("pyNastran.bdf.bdf")

    def attributes(words):
        model = bdf.BDF(debug=None)
        model.add_card([word or None for word in words], name)
        return {(k, key.lower()): repr(v) for k, card in enumerate(_objects(model)) for key, v in vars(card).items()}

    of_name = [card for card in CARDS if card.name == name and card.changes]
    assert of_name
    for card in of_name:
        before = attributes(card.words())
        for position, attribute, value, _ in card.changes:
            after = attributes(card.words(position, value))
            changed = {key[1] for key in before.keys() | after.keys() if before.get(key) != after.get(key)}
            assert attribute.lower() in changed, (card.text(), position, sorted(changed))


def _objects(model):
    """Yield the cards that a model of pyNastran holds."""
    for value in vars(model).values():
        things = value.values() if isinstance(value, dict) else value if isinstance(value, list) else [value]
        for thing in things:
            inner = thing if isinstance(thing, list) else [thing]
            yield from (one for one in inner if hasattr(one, "type") and hasattr(one, "__dict__"))


@pytest.mark.parametrize("flag", ["1", "2"])
def test_older_flags_of_orientation_say_nothing_new(tmp_path, flag):
    """Field 9 of a CBAR was 1 for a vector and 2 for a grid point; decks of today still have it."""
    before = written()
    assert before.count("CBAR,125,70,23,24,.1,1.,.2") == 1
    after = before.replace("CBAR,125,70,23,24,.1,1.,.2", f"CBAR,125,70,23,24,.1,1.,.2,{flag}")
    assert described(tmp_path, after) == described(tmp_path, before)
