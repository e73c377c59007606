"""What a world may have that the cell's model does not know of; each is written apart from the effects library."""

from robolaser.emulator.physics.backlash import Play
from robolaser.emulator.physics.effect import Departure
from robolaser.emulator.physics.encoders import Gain, OffCentre, Uneven, Zero
from robolaser.emulator.physics.light import Bent, Rolled
from robolaser.emulator.physics.weight import Sag

DEPARTURES: tuple[type[Departure], ...] = (Bent, Gain, OffCentre, Play, Rolled, Sag, Uneven, Zero)

__all__ = ["DEPARTURES", "Departure"]
