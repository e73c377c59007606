"""The page of a plan needs nothing else, and shows all sizes and pairs that the plan has."""

from dataclasses import replace

import numpy as np
from page_claims import (
    HOSTILE,
    is_whole,
    sound_charts,
)

from robolaser.data.stated_noise import Noise
from robolaser.diagnosis.pose_plan import examine_plan
from robolaser.model.effects.encoder_scale import EncoderScale
from robolaser.model.effects.joint_offset import JointOffset
from robolaser.report.page import render
from robolaser.report.pose_plan import document
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate


def test_the_page_of_a_plan_is_whole_and_shows_every_size() -> None:
    made = simulate(find_robot("scorbot_er7"), kind="point", poses=12, noise=Noise(point_m=3e-5), seed=1).dataset
    plan = examine_plan(replace(made, name=HOSTILE), [JointOffset, EncoderScale])
    text = render(document(plan, command="robolaser plan measured"))
    is_whole(text)
    (heat_map,) = sound_charts(text)
    pairs = heat_map["layer"][0]["data"]["values"]
    assert len(pairs) == np.isfinite(plan.of_effects()[1]).sum()
    assert all(text.count(f">{limit.candidate_effect.where}</span>") for limit in plan.limits)
    assert "robolaser plan measured" in text
