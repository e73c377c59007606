"""The page of a plan needs nothing else, and shows all sizes and pairs that the plan has."""

from dataclasses import replace

import numpy as np
from page_claims import (
    HOSTILE,
    is_closed_and_its_ids_are_its_own,
    is_small,
    needs_nothing_from_elsewhere,
    runs_only_our_own_scripts,
    sound_charts,
)

from robolaser.data.stated_noise import Noise
from robolaser.diagnosis.pose_plan import examine_plan
from robolaser.model.effects.encoder_scale import EncoderScale
from robolaser.model.effects.joint_offset import JointOffset
from robolaser.report.pose_plan import page
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate


def test_the_page_of_a_plan_is_whole_and_shows_every_size() -> None:
    made = simulate(find_robot("scorbot_er7"), kind="point", poses=12, noise=Noise(point_m=3e-5), seed=1).dataset
    plan = examine_plan(replace(made, name=HOSTILE), [JointOffset, EncoderScale])
    text = page(plan, command="robolaser plan measured")
    for claim in (
        is_closed_and_its_ids_are_its_own,
        is_small,
        needs_nothing_from_elsewhere,
        runs_only_our_own_scripts,
    ):
        claim(text)
    (heat_map,) = sound_charts(text)
    pairs = heat_map["layer"][0]["data"]["values"]
    assert len(pairs) == np.isfinite(plan.of_effects()[1]).sum()
    assert all(text.count(f">{limit.candidate_effect.where}</span>") for limit in plan.limits)
    assert "robolaser plan measured" in text
