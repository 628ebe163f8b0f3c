"""Every field, key option and real constant of every Ansys element that is read is used, told or refused."""

import pytest
from fem.archive_fields import CHANGES, DECK
from fem.test_card_fields import plain

from flexmb.errors import FlexmbError
from flexmb.fem.deck.ansys import read_ansys_deck

pytestmark = pytest.mark.filterwarnings("ignore::flexmb.fem.meshes.mesh.MeshWarning")
KINDS = sorted({what.split(":")[0].split(",")[0] for what, _, _ in CHANGES})


def described(tmp_path, text):
    """Return what an archive becomes, by field of `Deck`; the message if it is refused."""
    path = tmp_path / "fields.cdb"
    path.write_text(text)
    try:
        return {name: plain(value) for name, value in vars(read_ansys_deck(path)).items()}
    except FlexmbError as error:
        return str(error)


@pytest.mark.parametrize("kind", KINDS)
def test_every_field_is_used_told_or_refused(tmp_path, kind):
    before = described(tmp_path, DECK)
    assert isinstance(before, dict)
    own = [change for change in CHANGES if change[0].split(":")[0].split(",")[0] == kind]
    assert own
    unnoticed = [what for what, text, acts in own if acts and described(tmp_path, text) == before]
    acting = [what for what, text, acts in own if not acts and described(tmp_path, text) != before]
    assert not unnoticed
    assert not acting  # what has an effect after all belongs among the others
