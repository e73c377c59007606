"""What is said of a diagnosis: verdict, advice, and the lines on the terminal."""

from dataclasses import replace

import numpy as np
import pytest
from calibrated import arm, stripe
from diagnosed import GEOMETRIC, MADE, candidate_effect, of, unexplained, with_effects

from robolaser.diagnosis.cause_words import members, named
from robolaser.diagnosis.repeatability import NoiseSource, Repeatability
from robolaser.diagnosis.result import CauseClass, DetectionLimit, Estimate
from robolaser.diagnosis.summary_text import imitated_sentence, sentence
from robolaser.estimation.noise_limits import LARGEST_SCATTER
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


def test_a_verdict_says_millimetres_and_what_noise_gives(diagnosis):
    assert diagnosis.sentence.count(" mm") >= 2
    assert "noise alone gives 0.11 mm" in diagnosis.sentence
    assert diagnosis.sentence.endswith(".")


def test_gross_errors_are_counted_in_the_verdict():
    assert "One row" in MADE["no_gap"]().sentence
    assert "2 rows" in MADE["explained"]().sentence


def test_every_verdict_leads_to_something_to_do(diagnosis):
    said = to_do(diagnosis)
    assert said
    for found in diagnosis.findings:
        assert any(one.lower().startswith(named(found.candidate_effect).lower()) for one in said)


def doubted(diagnosis, probability=0.3, of_class=0.999, sets=()):
    """The same with no single effect certain, and one class that all of them belong to."""
    findings = tuple(replace(found, probability=probability) for found in diagnosis.findings)
    members = tuple((found.candidate_effect, probability) for found in findings)
    gap = diagnosis.gap
    classes = (CauseClass("arm_geometry", of_class, gap.calibrated_m, gap.after_m, members, sets),)
    said = sentence(diagnosis.verdict, findings, classes, diagnosis.where, gap, diagnosis.repeatability)
    return replace(diagnosis, findings=findings, classes=classes, sentence=said)


def test_a_certain_class_is_said_first_where_no_single_effect_is_certain():
    said = doubted(geometric()).sentence
    assert said.startswith(
        "The gap is explained by the arm's geometry (joint offset of perturb and link geometry of lift). With that"
    )
    assert "Which single effects of these are the cause, these poses do not show." in said


def test_members_that_are_not_reported_are_counted():
    one = doubted(geometric())
    some = (replace(one.classes[0], members=one.classes[0].members[:1]),)
    said = sentence("explained", one.findings, some, one.where, one.gap, one.repeatability)
    assert "by the arm's geometry (joint offset of perturb, and 1 more)" in said


def test_what_is_explained_is_never_perhaps():
    for one in (doubted(geometric()), doubted(geometric(), of_class=0.5)):
        assert "perhaps" not in one.sentence
    assert (
        "no cause is certain; most probable is the arm's geometry (50 %)" in doubted(geometric(), of_class=0.5).sentence
    )


def test_a_credible_set_is_said_as_a_choice():
    first = geometric().findings[0].candidate_effect
    said = doubted(geometric(), sets=((first, candidate_effect("encoder_scale:perturb")),)).sentence
    assert "The cause is joint offset of perturb or encoder scale of perturb. Which others are" in said


def test_a_certain_effect_is_named_beside_a_certain_class():
    one = doubted(geometric())
    findings = (replace(one.findings[0], probability=0.99), *one.findings[1:])
    said = sentence("explained", findings, one.classes, one.where, one.gap, one.repeatability)
    assert "Certain by itself: the zero of perturb is wrong. Which others" in said


def test_a_single_doubtful_effect_is_none_of_several():
    one = doubted(of(stripe(robot=arm(), effects=GEOMETRIC[:1])))
    assert "Whether joint offset of perturb or another one is the cause" in one.sentence


@pytest.mark.parametrize(("is_stated", "limit"), [(False, "than arms do"), (True, "than the data sheet allows")])
def test_scatter_that_counts_as_noise_is_said_to_be_within_its_limit(is_stated: bool, limit: str) -> None:
    one = geometric()
    source = NoiseSource(LARGEST_SCATTER["rad"], "rad", "estimated", of_poses=True)
    scatter = Repeatability({"joint": source}, 4e-4, is_stated)
    said = sentence("no_gap", (), (), (), one.gap, scatter)
    assert f"That is no more {limit}, and counts as noise." in said
    assert "how well the arm repeats" not in said


def test_a_rest_of_a_form_that_the_library_has_is_not_said_to_have_none():
    one = unexplained()
    known = [replace(lies, coordinate=f"placement of {lies.site}", unknown=False) for lies in one.where[:1]]
    (advice,) = (said for said in to_do(replace(one, where=tuple(known))) if said.startswith("Check"))
    assert "looks like a wrong placement of perturb" in advice
    assert "The library has effects of that form" in advice
    assert "in no form that an effect of the library has" not in advice


def test_what_was_found_to_stand_for_an_effect_is_not_called_untestable():
    one = replace(MADE["no_gap"](), not_testable={"joint_offset": "at turn it cannot be seen"})
    hidden = replace(one.limits[1], is_imitated=True)
    assert "Not testable: joint offset" in terminal(replace(one, limits=one.limits[1:]))
    assert "Not testable" not in terminal(replace(one, limits=(hidden,)))


def test_what_is_used_of_a_corrected_arm_is_nominal_where_the_data_see_nothing():
    one = doubted(geometric())
    unseen = [
        replace(found, parameters={name: replace(number, std=None) for name, number in found.parameters.items()})
        for found in one.findings
    ]
    said = to_do(replace(one, findings=tuple(unseen)))[0]
    assert "They do not determine 7 of 7 parameters by themselves" in said
    assert "the nominal model is kept" in said


def test_what_is_certain_of_an_arm_shares_the_advice_on_its_geometry():
    one = doubted(geometric())
    findings = (replace(one.findings[0], probability=0.99), *one.findings[1:])
    said = to_do(replace(one, findings=findings))
    assert sum("robot_corrected.urdf" in advice for advice in said) == 1


def test_the_terminal_shows_how_large_an_effect_is_rather_than_its_shape():
    one = of(with_effects(stripe(robot=arm()), ("transmission_error:perturb",)))
    assert "transmission_error:perturb cycles" not in terminal(one)


def test_what_no_effect_describes_is_said_though_the_gap_is_explained():
    one = doubted(geometric())
    unknown = CauseClass("unknown", 0.99, None, one.gap.after_m, site="base")
    said = sentence("explained", one.findings, (*one.classes, unknown), one.where, one.gap, one.repeatability)
    assert "The small remaining error is at base" in said
    assert "The little" not in one.sentence


def test_what_effects_only_imitate_is_said_where_no_class_is_likely():
    one = doubted(geometric())
    unknown = CauseClass("unknown", 0.8, None, one.gap.after_m, site="joint_4")
    said = sentence("explained", one.findings, (unknown,), one.where, one.gap, one.repeatability)
    assert "the cause at joint_4 is not an effect" in said
    assert "The little" not in said


def test_uncertain_effects_of_a_class_have_one_advice_together():
    said = to_do(doubted(geometric()))
    assert [one for one in said if "robot_corrected.urdf" in one] == [said[0]]
    assert not any("repair" in one for one in said)
    (uncertain, *_) = to_do(doubted(geometric(), of_class=0.5))
    assert uncertain.startswith("The arm's geometry: not certain. Measure more poses")


def test_a_parameter_on_its_bound_is_said_with_its_sign():
    diagnosis = geometric()
    first = diagnosis.findings[0]
    on_bound = replace(first, parameters={"offset": Estimate(-0.1, None, "rad", "lower")})
    assert caveats(on_bound)[0].startswith("offset ended on its lower bound, -5.73°")
    assert doubt(on_bound.parameters["offset"]) == "on its lower bound"


def test_a_spring_that_cannot_be_softer_than_none_has_no_larger_cause():
    diagnosis = geometric()
    bent = {"bending": Estimate(1e-5, 1e-6, "rad/Nm"), "twist": Estimate(0.0, None, "rad/Nm", "lower")}
    found = replace(diagnosis.findings[0], candidate_effect=candidate_effect("link_compliance:turn"), parameters=bent)
    assert not any("larger" in said for said in caveats(found))


def test_a_joint_that_begins_at_an_end_of_its_play_has_no_larger_cause():
    diagnosis = geometric()
    play = {"lost_motion": Estimate(3e-3, 1e-5, "rad", ""), "start": Estimate(-1.0, None, "", "lower")}
    found = replace(diagnosis.findings[0], candidate_effect=candidate_effect("backlash:turn"), parameters=play)
    assert not any("larger" in said for said in caveats(found))


def test_a_sensor_parameter_on_its_bound_is_to_be_seen_to():
    diagnosis = geometric()
    k = diagnosis.model.parameters.names.index("t_x")
    upper = diagnosis.model.parameters.upper[k]
    x = np.where(np.arange(len(diagnosis.x)) == k, upper, diagnosis.x)
    assert any(one.startswith("t_x ended on its upper bound") for one in to_do(replace(diagnosis, x=x)))
    assert not any("bound" in one for one in to_do(diagnosis))


def test_joints_are_listed_shortly():
    where = ["joint_2", "joint_3", "joint_5"]
    listed = [candidate_effect(f"joint_offset:{one}") for one in where]
    assert (
        members([*listed, candidate_effect("laser_roll:laser")]) == "joint offset of joint_2, 3 and 5, and laser roll"
    )
    assert members(listed[:2]) == "joint offset of joint_2 and joint_3"


def test_no_images_are_to_be_looked_at_where_there_are_none():
    tracked, scanned = (replace(one, outliers=np.array([0])) for one in (unexplained(), MADE["no_gap"]()))
    assert "Look at the measurements of the gross errors listed below; they are excluded here." in to_do(tracked)
    assert "Look at the images of the gross errors listed below; they are excluded here." in to_do(scanned)


def test_what_is_not_reported_is_not_advised_on():
    one = doubted(geometric())
    assert any("geometry" in said for said in to_do(one))
    assert not any("geometry" in said for said in to_do(replace(one, classes=())))


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


def test_names_are_not_taken_for_markup():
    assert "[bold]x[/bold]" in terminal(of(stripe(name="[bold]x[/bold]", robot=arm()), "no_gap"))


@pytest.mark.parametrize(("share", "said"), [(0.998, "99.8 %"), (1.0, "> 99.9 %"), (0.0, "< 0.1 %"), (0.5, "50 %")])
def test_nothing_is_certain(share, said):
    assert percent(share) == said


def test_a_cause_of_another_class_that_what_was_found_may_stand_for_is_said() -> None:
    found = (CauseClass("arm_geometry", 1.0, 1e-3, 1e-4),)
    scale = DetectionLimit(candidate_effect("tracker_scale:measuring_system"), "scale", None, "", is_imitated=True)
    same = DetectionLimit(candidate_effect("joint_offset:joint_2"), "offset", None, "rad", is_imitated=True)
    assert "cannot distinguish tracker scale from the effects found" in imitated_sentence([scale, same], found)
    assert imitated_sentence([same], found) == imitated_sentence([scale], ()) == ""
