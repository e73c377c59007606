"""What a world may have that the cell's model does not know of; each is written apart from the effects library."""

from robolaser.emulator.departures.backlash import Play
from robolaser.emulator.departures.departure import Departure
from robolaser.emulator.departures.encoders import Gain, OffCentre, Uneven, Zero
from robolaser.emulator.departures.light import Bent, Rolled
from robolaser.emulator.departures.weight import Sag

DEPARTURES: tuple[type[Departure], ...] = (Bent, Gain, OffCentre, Play, Rolled, Sag, Uneven, Zero)

__all__ = ["DEPARTURES", "Departure"]
