"""Every decoder against every stream: garbage, cuts at any byte, flipped bits; what is good comes through, once."""

from __future__ import annotations

import itertools
import math
from random import Random
from typing import TYPE_CHECKING

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ravengc.sensors.decoders import make_decoder
from sensor_frames import ENCODERS, Encoded, G, rosserial_frame, samples

if TYPE_CHECKING:
    from ravengc.sensors.decoders.base import Decoder
    from ravengc.sensors.sample import Measurement

FORMATS = sorted(ENCODERS)
CHECKED = sorted(set(FORMATS) - {"csv"})
"""Formats with a checksum."""
LONGEST_FRAME = 1100
COST = {"line": 0, "vectornav": 0, "witmotion": 2}
"""Good frames that garbage in front of them may cost, one where nothing stands here.

Text ends its garbage with a mark. WitMotion's garbage passes for a frame once in 256 times, if it begins as one and
lies where one is due.
"""
FALSE = {"witmotion": 1}
"""Samples that garbage may make."""
MARKS = (b"\xff\xfe", b"\xfd\x20\x00", b"\xfe\x1a", b"\xaa\xaa", b"\x55\x51", b"A,", b"$VN", b"*", b"\r", b"\xff", b",")


def noise(*, line_ends: bool = True) -> st.SearchStrategy[bytes]:
    """Random bytes with the marks among them that frames begin with."""
    marks = st.sampled_from((*MARKS, b"\n") if line_ends else MARKS)
    return st.lists(st.one_of(st.binary(max_size=40), marks), max_size=12).map(b"".join)


def meanings(measurements: list[Measurement]) -> list[tuple[float, ...]]:
    return [rounded(found.specific_force, found.angular_velocity) for found in measurements]


def expected(encoded: list[Encoded]) -> list[tuple[float, ...]]:
    return [rounded(sample.force, sample.rate) for sample in encoded]


def rounded(force: tuple[float, ...], rate: tuple[float, ...] | None) -> tuple[float, ...]:
    return tuple(round(value, 9) for value in (*force, *(rate or ())))


def fed(decoder: Decoder, pieces: list[bytes]) -> list[Measurement]:
    return [found for piece in pieces for found in decoder.feed(piece)]


def begun(form: str) -> tuple[Decoder, list[Encoded]]:
    """A decoder that has seen the stream's beginning, and the samples that follow."""
    encoded = samples(form, 14)
    decoder = make_decoder(form)
    for sample in encoded[:4]:
        decoder.feed(sample.data)
    return decoder, encoded[4:]


@pytest.mark.parametrize("form", FORMATS)
def test_a_good_stream_comes_through(form: str) -> None:
    decoder, encoded = begun(form)
    assert meanings(decoder.feed(b"".join(sample.data for sample in encoded))) == expected(encoded)
    counts = decoder.statistics
    assert counts.bad_checksum == counts.bad_content == counts.bytes_skipped == counts.resynchronisations == 0
    assert counts.frames_lost == 0


@pytest.mark.parametrize("form", FORMATS)
def test_a_stream_may_be_cut_anywhere(form: str) -> None:
    encoded = samples(form, 6)
    stream = b"".join(sample.data for sample in encoded)
    whole = meanings(make_decoder(form).feed(stream))
    bytewise = make_decoder(form)
    assert meanings(fed(bytewise, [stream[i : i + 1] for i in range(len(stream))])) == whole
    for cut in range(len(stream) + 1):
        assert meanings(fed(make_decoder(form), [stream[:cut], stream[cut:]])) == whole


@pytest.mark.parametrize("form", FORMATS)
@given(pieces=st.lists(noise(), max_size=20))
@settings(deadline=None)
def test_garbage_raises_nothing_and_fills_nothing(form: str, pieces: list[bytes]) -> None:
    samples(form, 1)
    decoder = make_decoder(form)
    for piece in pieces:
        decoder.feed(piece)
        decoder.outgoing(0)
        assert decoder.held <= LONGEST_FRAME
    assert all(count >= 0 for count in decoder.statistics.as_dict().values())


@pytest.mark.parametrize("form", FORMATS)
@given(byte=st.integers(0, 255))
@settings(max_examples=20, deadline=None)
def test_one_byte_for_ever_fills_nothing(form: str, byte: int) -> None:
    samples(form, 1)
    decoder = make_decoder(form)
    for _ in range(20):
        assert decoder.feed(bytes([byte]) * 4096) == []
        assert decoder.held <= LONGEST_FRAME


@pytest.mark.parametrize("form", FORMATS)
@given(pieces=st.lists(noise(), max_size=8), data=st.data())
@settings(deadline=None)
def test_cuts_change_nothing_in_garbage_either(form: str, pieces: list[bytes], data: st.DataObject) -> None:
    frames = [sample.data for sample in samples(form, 8)]
    stream = b"".join(part for pair in zip(frames, [*pieces, *[b""] * 8], strict=False) for part in pair)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=10)))
    parts = [stream[start:end] for start, end in zip([0, *cuts], [*cuts, len(stream)], strict=True)]
    whole, cut = make_decoder(form), make_decoder(form)
    assert repr(whole.feed(stream)) == repr(fed(cut, parts))
    assert whole.statistics == cut.statistics


@pytest.mark.parametrize("form", CHECKED)
@given(bursts=st.lists(noise(), min_size=10, max_size=10))
@settings(deadline=None)
def test_good_frames_between_garbage_come_through(form: str, bursts: list[bytes]) -> None:
    """Each burst costs one frame at most, and none where the checksum is strong; nothing else comes out."""
    decoder, encoded = begun(form)
    stream = [part for burst, sample in zip(bursts, encoded, strict=True) for part in (burst, sample.data)]
    found, wanted = meanings(fed(decoder, stream)), expected(encoded)
    forces, dirty = [entry[:3] for entry in wanted], sum(burst != b"" for burst in bursts)
    good = [entry for entry in found if entry[:3] in forces]
    assert len(found) - len(good) <= FALSE.get(form, 0) * dirty
    assert len(wanted) - len(good) <= COST.get(form, 1) * dirty


@pytest.mark.parametrize("form", FORMATS)
@given(burst=noise())
@settings(deadline=None)
def test_one_good_frame_behind_garbage_is_enough(form: str, burst: bytes) -> None:
    decoder, encoded = begun(form)
    found = meanings(fed(decoder, [burst, *(sample.data for sample in encoded)]))
    assert found[-len(encoded) + 1 :] == expected(encoded)[1:]


@pytest.mark.parametrize("form", CHECKED)
def test_no_flipped_bit_makes_another_sample(form: str) -> None:
    encoded = samples(form, 7)
    stream, second = b"".join(sample.data for sample in encoded), len(encoded[0].data)
    forces = [entry[:3] for entry in expected(encoded)]
    for place in range(8 * second, 8 * (second + len(encoded[1].data))):
        flipped = bytearray(stream)
        flipped[place // 8] ^= 1 << place % 8
        found = meanings(make_decoder(form).feed(bytes(flipped)))
        assert all(entry[:3] in forces for entry in found)
        assert len(found) >= len(encoded) - 2


@pytest.mark.parametrize(
    ("form", "most"), [("bno08x", 0.001), ("witmotion", 0.006), ("rosserial", 0.006), ("mavlink", 0.0)]
)
def test_frames_that_lost_a_byte_seldom_pass(form: str, most: float) -> None:
    """The share of false samples where every other frame lacks a byte somewhere; 1 in 256 for a plain sum."""
    random, encoded = Random(1), samples(form, 2000)  # noqa: S311
    forces = {entry[:3] for entry in expected(encoded)}
    decoder, false = make_decoder(form), 0
    for number, sample in enumerate(encoded):
        place = random.randrange(len(sample.data)) if number % 2 else len(sample.data)
        found = meanings(decoder.feed(sample.data[:place] + sample.data[place + 1 :]))
        false += sum(entry[:3] not in forces for entry in found)
    assert false <= most * len(encoded)
    assert decoder.statistics.resynchronisations > 900


@pytest.mark.parametrize("form", FORMATS)
def test_every_byte_is_accounted_for(form: str) -> None:
    """Behind garbage of which nothing can be the start of anything, the skipped bytes are those of the garbage."""
    decoder, encoded = begun(form)
    garbage = b"\x00\x01\x02 no frame \x03" * 3 + b"\n"
    decoder.feed(garbage + encoded[0].data + encoded[1].data)
    counts = decoder.statistics
    assert counts.bytes_skipped in (0, len(garbage), len(garbage) - 1)
    assert counts.bytes_skipped > 0 or counts.bad_content > 0
    assert counts.bad_checksum == 0


# What single formats do beyond that


def xor(body: bytes) -> int:
    total = 0
    for byte in body:
        total ^= byte
    return total


def checked_line(body: str) -> bytes:
    return f"{body}*{xor(body.encode()):02X}\n".encode()


def test_lines_without_a_gyroscope_and_with_another_unit_and_sign() -> None:
    decoder = make_decoder("line", unit="mg", sends="gravity")
    (found,) = decoder.feed(checked_line("A,7,0,0,-1000"))
    assert found == ((-0.0, -0.0, 9.80665), None, 7000, 1)


def test_what_an_arduino_prints_for_no_number_reaches_the_gate() -> None:
    decoder = make_decoder("line")
    (found,) = decoder.feed(checked_line("A,7,nan,inf,-1.5e0"))
    assert math.isnan(found.specific_force[0])
    assert found.specific_force[1:] == (math.inf, -1.5)


@pytest.mark.parametrize(
    "fields", ["1,2", "1,2,3,4", "1_0,2,3", "١,2,3", "infinity,2,3", "0x1,2,3", ",,", "1,2,3,", "1 2,3,4"]
)
def test_lines_that_make_no_sense_are_counted(fields: str) -> None:
    decoder = make_decoder("line")
    assert decoder.feed(checked_line(f"A,7,{fields}")) == []
    assert decoder.statistics.bad_content == 1
    assert "A,t_us,ax,ay,az" in decoder.remark


def test_a_microsecond_clock_wraps_without_a_jump() -> None:
    decoder = make_decoder("line")
    ticks = [2**32 - 20_000 + 10_000 * number for number in range(5)]
    found = decoder.feed(b"".join(checked_line(f"A,{tick % 2**32},0,0,9.8") for tick in ticks))
    assert [later.clock_ns - sooner.clock_ns for sooner, later in itertools.pairwise(found)] == [10_000_000] * 4


def test_csv_with_columns_units_and_a_header() -> None:
    decoder = make_decoder("csv", unit="g", gyro_unit="deg/s", columns="-,t_ms,gx,gy,gz,ax,ay,az")
    found = decoder.feed(b"cut off\nn;t;gx;gy;gz;ax;ay;az\n# comment\n5; 20; 180; 0; 0; 0; 0; 1\n")
    assert found == [((0.0, 0.0, 9.80665), (math.pi, 0.0, 0.0), 20_000_000, 1)]
    assert decoder.statistics.unconfirmed == decoder.statistics.bad_content == decoder.statistics.other_frames == 1


def test_csv_says_when_it_needs_to_know_the_columns() -> None:
    decoder = make_decoder("csv")
    assert decoder.feed(b"x\n1,2,3,4\n") == []
    assert "columns=t_us,ax,ay,az" in decoder.remark


def test_csv_takes_any_separator() -> None:
    decoder = make_decoder("csv")
    found = decoder.feed(b"x\n1,2,3\n1;2;3\n1\t2\t3\n1 2 3\n1 ,  2 , 3 \r\n")
    assert [measurement.specific_force for measurement in found] == [(1.0, 2.0, 3.0)] * 5


def test_bno08x_counts_what_its_index_says_was_lost() -> None:
    decoder, encoded = make_decoder("bno08x"), samples("bno08x", 300)
    kept = encoded[:250] + encoded[253:]
    found = decoder.feed(b"".join(sample.data for sample in kept))
    assert decoder.statistics.frames_lost == 3
    assert sum(measurement.steps for measurement in found) == 300


def test_witmotion_without_gyroscope_does_not_wait_for_it() -> None:
    decoder, (sample,) = make_decoder("witmotion"), samples("witmotion", 1)
    acceleration = sample.data[:11]
    assert len(decoder.feed(sample.data * 3)) == 3
    found = decoder.feed(acceleration * 3)
    assert [measurement.angular_velocity for measurement in found] == [None] * 3
    assert decoder.feed(acceleration)[0].angular_velocity is None


def test_the_sample_in_the_vectornav_manual_is_understood_and_has_z_down() -> None:
    """$VNRRG answers a question and is no output; its numbers under the header of VNACC are."""
    decoder = make_decoder("vectornav")
    assert decoder.feed(b"$VNRRG,18,+00.013,+00.354,-09.801*65\r\n") == []
    assert decoder.statistics.other_frames == 1
    body = b"VNACC,+00.013,+00.354,-09.801"
    (found,) = decoder.feed(b"$%s*%02X\r\n" % (body, xor(body)))
    assert found.specific_force == (0.013, 0.354, -9.801)


def test_vectornav_crc_is_that_of_its_manual() -> None:
    """The manual's algorithm, byte by byte."""
    crc, body = 0, b"VNACC,+00.013,+00.354,-09.801"
    for byte in body:
        crc = ((crc >> 8) | (crc << 8)) & 0xFFFF
        crc ^= byte
        crc ^= (crc & 0xFF) >> 4
        crc ^= (crc << 12) & 0xFFFF
        crc ^= ((crc & 0xFF) << 5) & 0xFFFF
    assert len(make_decoder("vectornav").feed(b"$%s*%04X\r\n" % (body, crc))) == 1


def test_vectornav_with_gravity_removed_is_refused_in_words() -> None:
    decoder, body = make_decoder("vectornav"), b"VNYBA,+1,+2,+3,+0.1,+0.2,+0.3,+0.01,+0.02,+0.03"
    assert decoder.feed(b"$%s*%02X\r\n" % (body, xor(body))) == []
    assert "gravity removed" in decoder.remark


PUBLISHED = [
    b"$VNYMR,+100.949,-007.330,+000.715,-00.0049,-00.2449,+00.5397,-01.258,-00.100,-09.701,-00.000018,+00.001122,-00.000551*69",
    b"$VNYMR,-165.981,-037.301,+001.245,+00.2901,+00.0720,+00.7482,-05.966,-00.150,-07.836,+00.001373,-00.001533,-00.001054*68",
    b"$VNYMR,-004.328,+001.357,+178.257,+00.2219,-00.0720,+00.4652,+00.226,-00.321,+10.043,-00.001188,+00.001866,-00.007661*6C",
    b"$VNYMR,-078.104,+005.642,+023.096,+00.0125,+00.1252,-00.1042,+00.878,-03.762,-08.854,-00.010387,-00.028062,-00.061305*68",
]
"""Lines of real sensors at rest with the checksums they were sent with: the first from the vendor's C library (its
example of the UART protocol), the others from comments in public ROS drivers of the VN-100."""


@pytest.mark.parametrize("line", PUBLISHED)
def test_published_vectornav_lines_feel_the_gravity_of_their_own_attitude(line: bytes) -> None:
    """Yaw, pitch and roll stand beside it: at rest f = -g (-sin p, sin r cos p, cos r cos p) in axes with z down."""
    decoder = make_decoder("vectornav")
    (found,) = decoder.feed(line + b"\r\n")
    _, _, pitch, roll, *_ = line.split(b",")
    p, r = math.radians(float(pitch)), math.radians(float(roll))
    expected = [-G * part for part in (-math.sin(p), math.sin(r) * math.cos(p), math.cos(r) * math.cos(p))]
    assert found.specific_force == pytest.approx(expected, abs=0.3)
    assert found.angular_velocity == tuple(float(field) for field in line.split(b"*")[0].split(b",")[10:13])
    assert max(map(abs, found.angular_velocity)) < 0.1, "at rest"
    broken = bytearray(line)
    broken[20] ^= 1
    assert make_decoder("vectornav").feed(bytes(broken) + b"\r\n") == []


def test_a_published_vnimu_line_has_its_fields_where_its_author_says() -> None:
    """Magnetometer, acceleration, turning, temperature, pressure, in a public driver for the VN-200 (mounted z up)."""
    line = (
        b"$VNIMU,-00.0350,+00.4222,-00.6643,-00.015,+00.019,+09.948,+00.002066,-00.008442,-00.044656,+20.7,+084.322*66"
    )
    (found,) = make_decoder("vectornav").feed(line + b"\r\n")
    assert found.specific_force == (-0.015, 0.019, 9.948)
    assert found.angular_velocity == (0.002066, -0.008442, -0.044656)


@pytest.mark.parametrize("form", ["line", "rosserial"])
def test_what_a_sensor_says_cannot_steer_a_terminal(form: str) -> None:
    words = b"found \x1b]0;title\x07\x1b[2J\xff ADXL345 " + b"x" * 300
    decoder = make_decoder(form)
    decoder.feed(b"# " + words + b"\n" if form == "line" else rosserial_frame(7, bytes(5) + words))
    assert decoder.remark.startswith("the sensor says: ")
    assert decoder.remark.isprintable()
    assert "ADXL345" in decoder.remark
    assert len(decoder.remark) < 250
