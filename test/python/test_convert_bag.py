"""Bags that were cut off: what is whole is read and said, the rest is one message."""
from __future__ import annotations

import pytest

numpy = pytest.importorskip("numpy")
pytest.importorskip("rosbag")
pytest.importorskip("amb_rotor.msg._TableRow")

from amb_rotor import cli  # noqa: E402
from amb_rotor.cli import convert  # noqa: E402

ROWS = 60000  # random numbers do not compress: several chunks of a bag


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp("bag") / "whole.bag"
    values = numpy.random.default_rng(1).normal(size=(ROWS, 3))
    convert.write_table(path, {"t_s": numpy.arange(ROWS) / 1e4, "ax_m": values[:, 0], "ay_m": values[:, 1],
                               "bx_m": values[:, 2]})
    return path


def test_a_whole_bag_is_read_without_a_word(bag, capsys):
    assert len(convert.read_bag(bag)["t_s"]) == ROWS
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("share", [0.5, 0.97])
def test_a_truncated_bag_is_read_up_to_the_cut(bag, tmp_path, capsys, share):
    data, cut = bag.read_bytes(), tmp_path / "cut.bag"
    cut.write_bytes(data[:int(share * len(data))])
    assert cli.main(["convert", str(cut), str(tmp_path / "table.csv")]) == 0
    printed = capsys.readouterr()
    assert "was cut off" in printed.err
    table, whole = convert.read_csv(tmp_path / "table.csv"), convert.read_bag(bag)
    rows = len(table["t_s"])
    # whole chunks of 768 kB, of which this bag has several
    assert 0.5 * share * ROWS < rows < ROWS
    for name, values in table.items():
        assert (values == whole[name][:rows]).all()
    assert cut.read_bytes() == data[:int(share * len(data))]  # the person's file stays as it is


@pytest.mark.parametrize("size, complaint", [(10, "bag"), (5000, "nothing in it is whole")])
def test_nothing_whole_is_one_message(bag, tmp_path, capsys, size, complaint):
    cut = tmp_path / "cut.bag"
    cut.write_bytes(bag.read_bytes()[:size])
    assert cli.main(["convert", str(cut), str(tmp_path / "table.csv")]) == 2
    message = capsys.readouterr().err
    assert complaint in message and "Traceback" not in message and not (tmp_path / "table.csv").exists()
