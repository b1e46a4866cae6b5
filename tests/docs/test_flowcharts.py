"""Flowcharts of the documents as pictures."""

import re

import pytest
from _documents import ROOT, Block, all_blocks

from flowcharts import columns_of, draw, read

SMALL = r"""flowchart LR
  z[/z, m/]
  late[/late, m/]
  a[\a, m/s\]
  x(x<br/>P_x)
  a --> x
  z --> x --> y(y) --> goal{{goal}}
  late --> y
  x --> goal
"""


def test_nodes_have_their_kind_and_words() -> None:
    nodes = read(SMALL).nodes
    assert {name: node.kind for name, node in nodes.items()} == {
        "z": "sensor",
        "late": "sensor",
        "a": "actuator",
        "x": "estimate",
        "y": "estimate",
        "goal": "goal",
    }
    assert nodes["x"].lines == ["x", "P_x"] and nodes["a"].lines == ["a, m/s"]


def test_a_node_stands_behind_what_it_reads_and_a_sensor_just_before_its_reader() -> None:
    assert columns_of(read(SMALL)) == {"z": 0, "a": 0, "x": 1, "late": 1, "y": 2, "goal": 3}


@pytest.mark.parametrize("block", all_blocks("mermaid"), ids=str)
def test_every_flowchart_of_the_documents_is_drawn_whole(block: Block) -> None:
    source = block.code
    chart, picture = read(source), draw(source)
    assert picture.count("<path") == len(chart.arrows) + 1  # and the head of an arrow
    assert picture.count("<rect") + picture.count("<polygon") == len(chart.nodes)
    for node in chart.nodes.values():
        for line in node.lines:
            assert f">{line}</text>" in picture


def test_boxes_of_a_column_do_not_overlap() -> None:
    for block in all_blocks("mermaid"):
        boxes = re.findall(
            r'<rect x="(.*?)" y="(.*?)" width="(.*?)" height="(.*?)"', draw(block.code)
        )
        spans = [[float(number) for number in box] for box in boxes]
        for number, (x, y, width, height) in enumerate(spans):
            for left, top, other_width, other_height in spans[:number]:
                beside = x + width <= left or left + other_width <= x
                assert beside or y + height <= top or top + other_height <= y


def test_what_is_no_flowchart_is_refused() -> None:
    with pytest.raises(ValueError, match="expected 'flowchart LR', got 'pie'"):
        draw("pie")
    with pytest.raises(ValueError, match="expected a node"):
        draw("flowchart LR\n  a b --> c")


def test_the_documents_have_flowcharts() -> None:
    assert {block.document.relative_to(ROOT).name for block in all_blocks("mermaid")} == {
        "graphs.md",
        "nav2d.md",
        "pusht.md",
        "arm_push.md",
    }
