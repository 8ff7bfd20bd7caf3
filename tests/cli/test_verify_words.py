"""Cases of verification by words of their names."""

from harness import Cli


def test_words_choose_cases(cli: Cli) -> None:
    said = cli("verify", "Leak-Down", "chamber compression", "--json")
    assert (said.code, said.json["passed"]) == (0, True)
    names = [one["name"] for one in said.json["cases"]]
    assert names == ["chamber compression", "chamber compression, air and walls", "leak-down"]


def test_a_word_of_no_case_is_refused(cli: Cli) -> None:
    said = cli("verify", "tiping")
    assert said.code == 2
    assert "'tiping': is in no name of a case; did you mean 'tipping'? there are chamber compression" in " ".join(
        said.err.split()
    )
