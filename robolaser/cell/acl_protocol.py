"""Requests to an ACL controller and their answers: a command is entered only after a correct echo."""

import re
from collections.abc import Callable, Sequence
from typing import TypeVar, final

from robolaser.cell.failures import AnswerUnclear, ArmRestarted, alarm, line_lost, refused, unclear
from robolaser.cell.serial_line import SerialLine

Reply = TypeVar("Reply")

ENTER = "\r"
ABORT = "\x01"  # Ctrl-A: stops all motion in any state
AT_ONCE = 4  # repetitions without waiting, for a line that loses bytes
SPOIL = "XQ"  # invalidates a misheard command that was not yet entered
QUIET_S = 0.9  # half of the longest silence; after the first half another attempt is made
TRIES = 3
PAUSE_S = 0.2
SLOW_PERCENT = 10  # speed of commands that state none [percent]
PROMPT = re.compile(">")
ECHO = re.compile("echo", re.IGNORECASE)
NOTHING = re.compile(r"(?!)")
LINE_END = re.compile(r"[\r\n>]")
BOOT = re.compile(r"SYSTEM READY|R[AO]M TEST|TEST COMPLETE|DEFAULT SETUP", re.IGNORECASE)
"""Lines that a controller prints when its power comes on; a disturbed line may lose some."""
REPORT = re.compile(r"\*\*\*[^\r\n>]*")
REFUSAL = re.compile(r"\*\*\*|ERROR|UNRECOGNI[SZ]ED|UNKNOWN|UNDEFINED|ILLEGAL|INVALID|\bBAD\b|\bNOT\b", re.IGNORECASE)
"""Refusals in the words of several controller versions; none is in the answer of an executed command."""
NUMBERED = re.compile(r"\*\*\*.*?\b(3\d\d)\b")
AXIS = re.compile(r"AXIS\s*(\d)", re.IGNORECASE)
TROUBLE = {
    re.compile("IMPACT|PROTECTION", re.IGNORECASE): "It ran into something: free the arm by hand and home it.",
    re.compile("RANGE", re.IGNORECASE): "The controller's own limits are narrower: leave that pose out.",
    re.compile("THERMIC|OVERLOAD", re.IGNORECASE): "A motor is too hot: let it cool down, and look for what blocks it.",
}
MEANING = {
    303: "no position is assigned; the controller may have been switched off in between",
    304: "an axis is disabled; switch the motors on",
    310: "there is no such axis",
    312: "a coordinate is outside the arm's range",
    317: "the point is outside the arm's range",
}


@final
class AclProtocol:
    """The controller echoes each character: a command is entered only when its echo is right.

    Each command is written in another mixture of capitals: its echo distinguishes its answer from a late one.

    Raises (every method): LineLost; ArmError where it sends without end or refuses a command; AnswerUnclear where an
    answer or an echo was never right; and the controller's own reports: ArmAlarm, ArmRestarted.
    """

    def __init__(self, line: SerialLine, joints: Sequence[str]) -> None:
        self._line = line
        self._joints = joints
        self._turn = 0
        self._mixing = False
        self._begun = False
        self._unfinished = ""

    def begin(self) -> None:
        """Stop a running program; get a prompt and the echo, or else AnswerUnclear: the device is no ACL controller."""
        heard = ""
        for _ in range(TRIES):
            self._line.send(ABORT + SPOIL)
            heard, prompt = self._prompted()
            if not prompt:
                continue
            self._line.send("ECHO" + ENTER)
            self._line.until(PROMPT, QUIET_S)
            self.settle()
            self._line.send("eCHo")
            heard, echo = self._line.until(ECHO, QUIET_S)
            if echo and self._prompted()[1]:
                self._mixing = echo[0] == "eCHo"
                self._begun = True
                return
        raise self._unclear("ECHO", heard)

    def ask(self, command: str, understand: Callable[[str], Reply | None]) -> Reply:
        """Repeat a request, in capitals, until its answer can be understood: None is a corrupt one."""
        answer, refusals = "", []
        for _ in range(TRIES):
            if not self._typed(command):
                continue
            answer, _ = self._prompted()
            self.inspect(answer, command)
            value = understand(answer)
            if value is not None:
                return value
            refusals += REPORT.findall(answer)[-1:]
        if len(refusals) == TRIES and len(set(refusals)) == 1:  # a disturbed line does not repeat itself
            raise refused(self._line.port, command, refusals[0].strip(), "")
        raise self._unclear(command, answer)

    def command(self, command: str) -> None:
        """Execute a command."""
        self.ask(command, lambda answer: True if ">" in answer and not REFUSAL.search(answer) else None)

    def start(self, command: str) -> None:
        """Enter a command without waiting for its answer."""
        for _ in range(TRIES):
            if self._typed(command):
                self._line.send(ENTER)
                return
        raise self._unclear(command, "")

    def listen(self) -> None:
        """Process the controller's own reports since the last command."""
        self.inspect(self._line.discard())

    def inspect(self, text: str, command: str = "") -> None:
        """Check received text for reported faults, or for the refusal of a command whose echo was right."""
        if not self._begun:
            return
        *lines, rest = LINE_END.split(self._unfinished + text)
        self._unfinished = rest
        for line in lines:
            if BOOT.search(line):
                raise ArmRestarted(
                    f"The controller on {self._line.port} has restarted: its counts may no longer mean the same angles."
                    " Home the arm (home = true in cell.toml, [arm]) before going on."
                )
            if "***" in line:
                self._complain(line[line.index("***") :].strip(), command)

    def abort(self) -> None:
        """Stop all motion, now."""
        self._line.send(ABORT * AT_ONCE)

    def settle(self) -> None:
        """Discard text that is still being sent."""
        self._line.until(NOTHING, PAUSE_S)

    def _typed(self, command: str) -> bool:
        """Type a command without entering it; whether its echo was right. A misheard one is invalidated."""
        self.listen()
        text = self._mixed(command)
        self._line.send(text)
        heard, echo = self._line.until(re.compile(re.escape(text), 0 if self._mixing else re.IGNORECASE), QUIET_S)
        self.inspect(heard)
        if echo:
            return True
        self._line.send(SPOIL + ENTER)
        self.inspect(self._silent_or(heard + self._line.until(PROMPT, QUIET_S)[0])[len(heard) :])
        return False

    def _prompted(self) -> "tuple[str, re.Match[str] | None]":
        """Enter, and wait for the prompt; once more after silence."""
        self._line.send(ENTER)
        answer, prompt = self._line.until(PROMPT, QUIET_S)
        if not answer:
            self._line.send(ENTER)
            answer, prompt = self._line.until(PROMPT, QUIET_S)
        return self._silent_or(answer), prompt

    def _mixed(self, command: str) -> str:
        """The command's first word in the next mixture of capitals."""
        if not self._mixing:
            return command
        self._turn += 1
        word, space, rest = command.partition(" ")
        letters = (c.lower() if self._turn >> i & 1 else c for i, c in enumerate(word))
        return "".join(letters) + space + rest

    def _silent_or(self, heard: str) -> str:
        if not heard:
            raise line_lost(self._line.port, f"no answer for {2 * QUIET_S:.1f} s")
        return heard

    def _complain(self, line: str, command: str) -> None:
        for pattern, advice in TROUBLE.items():
            if pattern.search(line):
                axis = AXIS.search(line)
                number = int(axis[1]) if axis else 0
                joint = self._joints[number - 1] if 0 < number <= len(self._joints) else "no joint is named"
                raise alarm(self._line.port, joint, line, advice)
        numbered = NUMBERED.search(line)
        if numbered and command:
            raise refused(self._line.port, command, line, MEANING.get(int(numbered[1]), ""))

    def _unclear(self, command: str, answer: str) -> AnswerUnclear:
        return unclear(self._line.port, command, answer, TRIES)
