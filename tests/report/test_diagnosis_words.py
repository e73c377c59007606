"""What is said of a diagnosis: verdict, advice, and the lines on the terminal."""

from dataclasses import replace

import numpy as np
import pytest
from calibrated import arm, stripe
from diagnosed import GEOMETRIC, MADE, candidate_effect, of, unexplained

from robolaser.diagnosis.cause_words import members, named
from robolaser.diagnosis.corrected_model import corrected
from robolaser.diagnosis.pose_scatter import PartScatter, Spread
from robolaser.diagnosis.result import CauseClass, DetectionLimit, Estimate, NoiseSource, Repeatability
from robolaser.diagnosis.summary_text import imitated_sentence, scatters, sentence
from robolaser.estimation.noise_estimate import LARGEST_SCATTER
from robolaser.report.console import printed
from robolaser.report.diagnosis.advice import caveats, doubt, to_do
from robolaser.report.diagnosis.page import document
from robolaser.report.digits import percent


@pytest.fixture(params=MADE)
def diagnosis(request):
    return MADE[request.param]()


def geometric():
    return of(stripe(robot=arm(), effects=GEOMETRIC), rivals=("encoder_scale:perturb",))


def terminal(diagnosis):
    return printed(document(diagnosis, brief=True))


def test_a_verdict_says_millimetres_and_what_noise_gives_and_leads_to_something_to_do(diagnosis):
    assert diagnosis.sentence.count(" mm") >= 2
    assert "noise alone gives 0.11 mm" in diagnosis.sentence
    said = to_do(diagnosis)
    assert said
    for found in diagnosis.findings:
        assert any(one.lower().startswith(named(found.candidate_effect).lower()) for one in said)


def test_the_next_poses_are_said_to_decide_about_the_least_probable_effect():
    one = MADE["explained"]()
    first, second, *rest = one.findings
    sure = replace(one, findings=(replace(first, probability=0.95), replace(second, probability=0.6), *rest))
    (said,) = [text for text in to_do(sure) if text.startswith("Measure the")]
    other = second.alternatives[0].candidate_effect
    assert said.endswith(f"they distinguish {named(second.candidate_effect)} from {named(other)}.")


def test_gross_errors_are_counted_in_the_verdict():
    assert "One row" in MADE["no_gap"]().sentence
    assert "2 rows" in MADE["explained"]().sentence


def resaid(one):
    """The same with the sentence that its findings and classes make."""
    said = sentence(one.verdict, one.findings, one.classes, one.where, one.gap, one.repeatability)
    return replace(one, sentence=said)


def doubted(diagnosis, probability=0.3, of_class=0.999, sets=()):
    """The same with no single effect certain, and one class that all of them belong to."""
    findings = tuple(replace(found, probability=probability) for found in diagnosis.findings)
    members = tuple((found.candidate_effect, probability) for found in findings)
    gap = diagnosis.gap
    classes = (CauseClass("arm_geometry", of_class, gap.calibrated_m, gap.after_m, members, sets),)
    return resaid(replace(diagnosis, findings=findings, classes=classes))


def first_certain():
    one = doubted(geometric())
    return resaid(replace(one, findings=(replace(one.findings[0], probability=0.99), *one.findings[1:])))


def one_member_reported():
    one = doubted(geometric())
    return resaid(replace(one, classes=(replace(one.classes[0], members=one.classes[0].members[:1]),)))


def with_credible_set():
    first = geometric().findings[0].candidate_effect
    return doubted(geometric(), sets=((first, candidate_effect("encoder_scale:perturb")),))


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: doubted(geometric()), "The gap is explained by the arm's geometry (joint offset of perturb and link"),
        (lambda: doubted(geometric()), "These poses do not show which of these single effects are the cause."),
        (one_member_reported, "by the arm's geometry (joint offset of perturb, and 1 more)"),
        (lambda: doubted(geometric(), of_class=0.5), "no cause is certain; most probable is the arm's geometry (50 %)"),
        (with_credible_set, "The cause is joint offset of perturb or encoder scale of perturb. These poses do"),
        (first_certain, "Certain individually: the zero of perturb is wrong. These poses do"),
        (
            lambda: doubted(of(stripe(robot=arm(), effects=GEOMETRIC[:1]))),
            "These poses do not show whether joint offset of perturb or another",
        ),
    ],
)
def test_a_verdict_says_first_what_is_certain_and_then_what_is_not(make, said):
    assert said in make().sentence


def test_a_remaining_gap_begins_with_the_unknown_where_no_class_of_what_was_found_is_likely():
    one = doubted(geometric(), of_class=0.07)
    unknown = CauseClass("unknown", 0.9995, None, one.gap.after_m, site="measuring_system")
    left = replace(unexplained().where[0], site="measuring_system", coordinate="distance")
    told = resaid(replace(one, verdict="unexplained", classes=(unknown, *one.classes), where=(left,)))
    assert to_do(told)[0].startswith("Check the measuring system")
    assert "They only imitate the cause" in "".join(to_do(told))
    assert told.sentence.startswith(
        "The gap is real, but its cause is almost certainly not an effect of the library. The error is at"
        " the measuring system (distance). The effects found only imitate it; the most probable of them is the arm's"
        " geometry (7 %). With them in the model the error on new poses falls from"
    )


def test_a_remaining_gap_is_not_said_to_close_where_its_place_is_not_found():
    one = doubted(geometric(), of_class=0.07)
    unknown = CauseClass("unknown", 0.8, None, one.gap.after_m, site="base")
    told = resaid(replace(one, verdict="unexplained", classes=(unknown, *one.classes), where=())).sentence
    assert told.startswith("The gap is real, but its cause, at the base, is probably not an effect of the library. The")


@pytest.mark.parametrize(
    ("is_stated", "limit"), [(False, "the usual repeatability of arms"), (True, "the stated repeatability")]
)
def test_scatter_that_counts_as_noise_is_said_to_be_within_its_limit(is_stated, limit):
    one = geometric()
    source = NoiseSource(LARGEST_SCATTER["rad"], "rad", "estimated", of_poses=True)
    said = sentence("no_gap", (), (), (), one.gap, Repeatability({"joint": source}, 4e-4, is_stated))
    assert f"This is within {limit} and counts as noise." in said


@pytest.mark.parametrize(("probe_turn", "helps"), [(1e-5, True), (1e-3, False)])
def test_finer_readings_are_advised_where_readings_scatter_most(probe_turn, helps):
    turns = {"joint": 1e-4, "probe_turn": probe_turn}
    sources = {name: NoiseSource(value, "rad", "estimated", of_poses=True) for name, value in turns.items()}
    one = MADE["no_gap"]()
    advice = " ".join(to_do(replace(one, repeatability=Repeatability(sources, one.gap.noise_floor_m))))
    assert "Most of the error is scatter of whole poses" in advice
    assert ("finer resolution" in advice) is helps


@pytest.mark.parametrize("is_stated", [False, True])
def test_who_has_not_stated_how_well_the_arm_repeats_is_asked_to(is_stated):
    one = MADE["no_gap"]()
    source = NoiseSource(1e-4, "rad", "estimated", of_poses=True)
    scatter = Repeatability({"joint": source}, one.gap.noise_floor_m, is_stated)
    advice = " ".join(to_do(replace(one, repeatability=scatter)))
    assert "Nothing needs repair" in advice
    assert ("`repeatability_m`" in advice) is not is_stated


def test_where_noise_is_stated_too_large_nobody_is_told_that_nothing_needs_repair():
    one = MADE["no_gap"]()
    one = replace(one, gap=replace(one.gap, noise_floor_m=2.0 * one.gap.after_ci95_m[1]))
    advice = " ".join(to_do(one))
    assert "Nothing needs repair" not in advice
    assert "State less noise" in advice


def test_of_a_flange_that_scatters_only_what_exceeds_its_limit_is_said():
    sizes = {"shift": Spread(7e-4, 1e-4, "m", limit=3e-4), "turn": Spread(1e-6, 1e-6, "rad", limit=5e-4)}
    noise = geometric().model.dataset.noise
    found = PartScatter("flange", 1.0, sizes, None, 50.0, 0.0, 7e-4, noise, noise)
    assert scatters(found).startswith("The flange scatters by 0.7 mm from pose to pose, more than is usual for arms:")


def test_a_rest_of_a_form_that_the_library_has_is_not_said_to_have_none():
    one = unexplained()
    known = [replace(lies, coordinate=f"placement of {lies.site}", unknown=False) for lies in one.where[:1]]
    (advice,) = (said for said in to_do(replace(one, where=tuple(known))) if said.startswith("Check"))
    assert "looks like a wrong placement of perturb" in advice
    assert "The library has effects of that form" in advice


def test_what_was_found_to_stand_for_an_effect_is_not_called_untestable():
    one = replace(MADE["no_gap"](), not_testable={"joint_offset": "at turn it cannot be seen"})
    hidden = replace(one.limits[1], is_imitated=True)
    assert "Not testable or not detectable: joint offset" in terminal(replace(one, limits=one.limits[1:]))
    assert "Not testable" not in terminal(replace(one, limits=(hidden,)))


def test_what_is_used_of_a_corrected_arm_is_nominal_where_the_data_see_nothing():
    one = doubted(geometric())
    unseen = [
        replace(found, parameters={name: replace(number, std=None) for name, number in found.parameters.items()})
        for found in one.findings
    ]
    said = to_do(replace(one, findings=tuple(unseen)))[0]
    assert "They do not determine 7 of 7 parameters by themselves" in said


def test_uncertain_effects_of_a_class_have_one_advice_together_with_what_is_certain_of_it():
    for one in (doubted(geometric()), first_certain()):
        said = to_do(one)
        assert [advice for advice in said if "robot_corrected.urdf" in advice] == [said[0]]
        assert not any("arm's geometry" in advice for advice in to_do(replace(one, classes=())))
    (uncertain, *_) = to_do(doubted(geometric(), of_class=0.5))
    assert uncertain.startswith("The arm's geometry: not certain. Measure more poses")


def test_a_parameter_on_its_bound_is_said_with_its_sign():
    on_bound = replace(geometric().findings[0], parameters={"offset": Estimate(-0.1, None, "rad", "lower")})
    assert caveats(on_bound)[0].startswith("offset ended on its lower bound, -5.73°")
    assert doubt(on_bound.parameters["offset"]) == "on its lower bound"


def test_a_bound_that_is_natural_has_no_larger_cause():
    """A spring is no softer than none, and a joint may begin at an end of its play."""
    none, start = Estimate(0.0, None, "rad/Nm", "lower"), Estimate(-1.0, None, "", "lower")
    spring = {"bending": Estimate(1e-5, 1e-6, "rad/Nm"), "twist": none}
    play = {"lost_motion": Estimate(3e-3, 1e-5, "rad"), "start": start}
    for effect, numbers in (("link_compliance:turn", spring), ("backlash:turn", play)):
        found = replace(geometric().findings[0], candidate_effect=candidate_effect(effect), parameters=numbers)
        assert not any("larger" in said for said in caveats(found))


def test_a_sensor_parameter_on_its_bound_is_to_be_seen_to():
    diagnosis = geometric()
    k = diagnosis.model.parameters.names.index("t_x")
    x = np.where(np.arange(len(diagnosis.x)) == k, diagnosis.model.parameters.upper[k], diagnosis.x)
    assert any(one.startswith("t_x ended on its upper bound") for one in to_do(replace(diagnosis, x=x)))
    assert not any("bound" in one for one in to_do(diagnosis))


def test_no_bounds_of_effects_are_to_be_widened():
    """No file has them."""
    diagnosis = geometric()
    effects = np.isin(diagnosis.model.parameters.names, diagnosis.model.effect_parameters.names)
    ended = replace(diagnosis, x=np.where(effects, diagnosis.model.parameters.upper, diagnosis.x))
    assert not any("widen" in said for said in (*to_do(ended), *corrected(ended, 0).warnings))


def test_joints_are_listed_shortly():
    where = ["joint_2", "joint_3", "joint_5"]
    listed = [candidate_effect(f"joint_offset:{one}") for one in where]
    assert (
        members([*listed, candidate_effect("laser_roll:laser")]) == "joint offset of joint_2, 3 and 5, and laser roll"
    )
    assert members(listed[:2]) == "joint offset of joint_2 and joint_3"
    assert members([candidate_effect("joint_offset:joint_10"), *listed]) == "joint offset of joint_2, 3, 5 and 10"


def test_no_images_are_to_be_looked_at_where_there_are_none():
    for one, what in ((unexplained(), "measurements"), (MADE["no_gap"](), "images")):
        said = to_do(replace(one, outliers=np.array([0])))
        assert f"Look at the {what} of the `gross_errors` in `diagnosis.json`; they are excluded here." in said


def test_the_terminal_cuts_no_name_however_long_the_caveat():
    one = of(stripe(robot=arm(), effects=GEOMETRIC), rivals=("encoder_eccentricity:perturb",) * 3)
    text = terminal(one).lower()
    assert all(named(found.candidate_effect) in text for found in one.findings)
    assert "and 1 more" in text


def test_the_terminal_takes_some_twenty_lines_of_plain_text(diagnosis):
    text = terminal(diagnosis)
    assert "\x1b" not in text
    assert len(text.splitlines()) < 24
    for found in diagnosis.findings:
        assert named(found.candidate_effect).lower() in text.lower()


@pytest.mark.parametrize(("share", "said"), [(0.998, "99.8 %"), (1.0, "> 99.9 %"), (0.0, "< 0.1 %"), (0.5, "50 %")])
def test_nothing_is_certain(share, said):
    assert percent(share) == said


def test_a_cause_of_another_class_that_what_was_found_may_stand_for_is_said():
    found = (CauseClass("arm_geometry", 1.0, 1e-3, 1e-4),)
    scale = DetectionLimit(candidate_effect("tracker_scale:measuring_system"), "scale", None, "", is_imitated=True)
    same = DetectionLimit(candidate_effect("joint_offset:joint_2"), "offset", None, "rad", is_imitated=True)
    assert "cannot distinguish tracker scale from the effects found" in imitated_sentence([scale, same], found)
    assert imitated_sentence([same], found) == imitated_sentence([scale], ()) == ""
