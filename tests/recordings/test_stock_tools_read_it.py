"""A recording is an ordinary MCAP file: these tests read it with the mcap library and protobuf alone."""

from __future__ import annotations

import importlib.util
import json
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory  # type: ignore[import-untyped]
from mcap.reader import NonSeekingReader, make_reader
from mcap.records import Attachment, Header, Message, Metadata
from mcap.stream_reader import StreamReader
from numpy.typing import NDArray

SECOND = 1_000_000_000


def decoded(schema: Any, data: bytes) -> Any:
    """A message decoded with nothing but the schema that the file carries."""
    pool = descriptor_pool.DescriptorPool()
    for file in descriptor_pb2.FileDescriptorSet.FromString(schema.data).file:
        pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(schema.name)).FromString(data)


def test_all_checksums_of_a_recording_are_correct_and_every_channel_has_a_schema(recorded: Path) -> None:
    with recorded.open("rb") as stream:
        messages = list(NonSeekingReader(stream, validate_crcs=True).iter_messages())
        stream.seek(0)
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert all(channel.schema_id for channel in summary.channels.values())
    assert {schema.encoding for schema in summary.schemas.values()} == {"protobuf", "jsonschema"}
    assert len(messages) == 3 + 1 + 1 + 6 * 2


def test_the_log_time_of_recorded_messages_is_the_simulation_time_and_never_decreases(recorded: Path) -> None:
    with recorded.open("rb") as stream:
        found = [
            (channel.topic, message) for _, channel, message in make_reader(stream).iter_messages(log_time_order=False)
        ]
    times = [message.log_time for _, message in found]
    assert times == sorted(times)
    assert [m.log_time for topic, m in found if topic == "/samples"] == [
        0,
        SECOND,
        2 * SECOND,
        2_500_000_000,
        3 * SECOND,
        4 * SECOND,
    ]
    assert [m.log_time for topic, m in found if topic == "/commander/stage"] == [0, SECOND, 3 * SECOND]
    assert all(message.log_time == message.publish_time for _, message in found)


def test_a_recording_begins_with_metadata_of_the_run_and_ends_with_its_result(recorded: Path) -> None:
    with recorded.open("rb") as stream:
        records = list(StreamReader(stream, validate_crcs=True).records)
    header, run, scene = records[:3]
    assert isinstance(header, Header)
    assert header.library == f"heavylift {version('heavylift')} mcap-python/{version('mcap')}"
    assert isinstance(run, Metadata)
    assert run.name == "run"
    assert run.metadata == {
        "format": "2",
        "scene": "lift",
        "seed": "7",
        "rated": '{"west.H1":900000.0}',
        "loaders": '{"loader-1":"west.H1"}',
    }
    assert isinstance(scene, Attachment)
    assert (scene.name, scene.data) == ("lift.yaml", b"heavylift: 1\n")
    last_message = max(i for i, record in enumerate(records) if isinstance(record, Message))
    metadata = [record for record in records if isinstance(record, Metadata)]
    assert [record.name for record in metadata] == ["run", "result"]
    assert records.index(metadata[-1]) > last_message
    assert metadata[-1].metadata["status"] == "finished"


def test_recorded_numbers_are_decoded_with_the_schema_in_the_file(recorded: Path, rows: NDArray[np.float64]) -> None:
    with recorded.open("rb") as stream:
        found = list(make_reader(stream).iter_messages(topics=["/samples", "/poses"]))
    samples = [(s, c, m) for s, c, m in found if c.topic == "/samples"]
    schema, channel, message = samples[2]
    assert schema is not None
    assert schema.name == "heavylift.Samples"
    tension, _, when = json.loads(channel.metadata["signals"])
    assert tension == {
        "signal": "rope/tension",
        "field": "rope_tension",
        "unit": "N",
        "columns": ["west.H1", "west.H2"],
    }
    assert (when["field"], when["unit"]) == ("rope_peak_time", "s")
    assert list(decoded(schema, message.data).rope_tension) == list(rows[2, :2])
    schema, _, message = next((s, c, m) for s, c, m in found if c.topic == "/poses" and m.log_time == SECOND)
    block, hook = decoded(schema, message.data).transforms
    assert (block.parent_frame_id, block.child_frame_id, hook.child_frame_id) == ("world", "block", "hook")
    assert [hook.rotation.x, hook.rotation.w] == [rows[1, 16], rows[1, 19]]
    assert block.timestamp.seconds == 1


def test_recorded_events_conform_to_their_json_schema(recorded: Path) -> None:
    with recorded.open("rb") as stream:
        schema, channel, message = next(make_reader(stream).iter_messages(topics=["/commander/stage"]))
        stream.seek(0)
        protocol = next(make_reader(stream).iter_messages(topics=["/protocol/west"]))[2]
    assert json.loads(message.data) == {
        "t_ns": 0,
        "microstep": 1,
        "source": "commander",
        "port": "stage",
        "index": 0,
        "type": "Stage",
        "value": {"name": "take up", "number": 0},
    }
    assert channel.metadata["key"] == "heavylift/r/event/commander/stage"
    assert schema is not None
    root = json.loads(schema.data)
    assert root["type"] == "object"
    assert root["properties"]["value"] == {"$ref": "#/$defs/Stage"}
    assert list(root["$defs"]["Stage"]["properties"]) == ["name", "number"]
    assert json.loads(protocol.data)["raw"] == "AQI="


@pytest.mark.parametrize("topic", ["/scene", "/ropes"])
def test_a_recording_without_shapes_and_ropes_has_no_messages_on_the_topics_of_shapes_and_ropes(
    recorded: Path, topic: str
) -> None:
    with recorded.open("rb") as stream:
        assert list(make_reader(stream).iter_messages(topics=[topic])) == []


@pytest.mark.skipif(importlib.util.find_spec("mcap_protobuf") is None, reason="mcap-protobuf-support is not installed")
def test_the_standard_protobuf_library_decodes_every_recorded_message(
    recorded: Path, rows: NDArray[np.float64]
) -> None:
    from mcap_protobuf.decoder import DecoderFactory

    with recorded.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        found = [(x[1].topic, x[3]) for x in reader.iter_decoded_messages(topics=["/samples", "/poses", "/log"])]
    names = [type(message).__name__ for _, message in found]
    assert {name: names.count(name) for name in set(names)} == {"Samples": 6, "FrameTransforms": 6, "Log": 1}
    samples = [message for topic, message in found if topic == "/samples"]
    assert [list(x.rope_tension) for x in samples] == rows[:, :2].tolist()
    frames = [message for topic, message in found if topic == "/poses"]
    assert [x.transforms[0].translation.z for x in frames] == rows[:, 8].tolist()
