"""What happens when: events end a phase, their actions make the model of the next one."""

from flexmb.events.change import Change
from flexmb.events.event import Action, Event
from flexmb.events.impact import Impact
from flexmb.events.lock import Lock, Unlock
from flexmb.events.release import Release
from flexmb.events.stop import Stop

KINDS = {"Event": Event}
"""All kinds of events by name: read by the model files."""

ACTIONS = {kind.__name__: kind for kind in (Release, Lock, Unlock, Stop, Change, Impact)}
"""All actions by name: read by the model files."""

__all__ = ["ACTIONS", "KINDS", "Action", "Change", "Event", "Impact", "Lock", "Release", "Stop", "Unlock"]
