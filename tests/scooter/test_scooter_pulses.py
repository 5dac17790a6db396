"""Scooter, pulses: motion by the Hall sensor, and the clock of a second logger."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mobility_imu.errors import InputError
from mobility_imu.scooter import pulses as module
from mobility_imu.scooter.pulses import moving_samples, reference_angles, synchronise


def pulses_of_a_ride(rng, count=60):
    """Start, drive at constant speed, stop: intervals shrink, stay, and grow."""
    ramp = np.array([0.6, 0.35, 0.26, 0.22])
    steps = np.concatenate([ramp, np.full(count, 0.184), ramp[::-1]])
    return 1.0 + np.cumsum(steps) + rng.uniform(0, 0.001, len(steps))


class TestMotion:
    def test_standstill_within_a_ride_is_cut_out(self):
        pulses = np.concatenate([np.arange(2, 4, 0.2), np.arange(7, 9, 0.2)])
        time_s = np.arange(0, 10, 0.01)
        moving = moving_samples(time_s, pulses, longest_gap_s=1.0)
        expected = ((time_s >= 2) & (time_s < 3.8)) | ((time_s >= 7) & (time_s < 8.8))
        assert (moving != expected).sum() <= 4  # rounding of the pulses' own times

    @pytest.mark.parametrize(
        ("pulses", "moving"),
        [
            ([1.0, 3.0, 3.6, 4.2], {3.2, 3.8}),
            ([1.0, 1.6, 2.2, 4.2], {1.2, 1.8}),
            ([1.0, 1.6, 3.4, 4.2], {1.2, 3.8}),
            ([1.0, 4.2], set()),
            ([3.0, 3.9], {3.2, 3.8}),
        ],
    )
    def test_each_gap_between_two_pulses_counts_by_itself(self, pulses, moving):
        times = [0.5, 1.2, 1.8, 2.6, 3.2, 3.8, 4.4]
        found = moving_samples(times, pulses, longest_gap_s=1.0)
        assert {t for t, m in zip(times, found, strict=True) if m} == moving

    def test_no_pulse_no_motion(self):
        assert not moving_samples(np.arange(10.0), [], longest_gap_s=1.0).any()
        assert not moving_samples(np.arange(10.0), [3.0], longest_gap_s=1.0).any()

    @pytest.mark.parametrize(
        ("pulses", "gap", "words"),
        [([2.0, 1.0], 1.0, "in order"), ([1.0, np.nan], 1.0, "finite"), ([1.0], 0.0, "positive")],
    )
    def test_bad_input(self, pulses, gap, words):
        with pytest.raises(InputError, match=words):
            moving_samples(np.arange(5.0), pulses, longest_gap_s=gap)


class TestSynchronise:
    @given(
        offset=st.floats(-20, 20),
        missing=st.sets(st.integers(0, 67), max_size=3),
        seed=st.integers(0, 100),
    )
    def test_offset_found_with_missing_pulses(self, offset, missing, seed):
        """Second logger samples at 100 Hz: up to 10 ms late, so the offset is within that."""
        ours = pulses_of_a_ride(np.random.default_rng(seed))
        theirs = np.delete(np.ceil((ours + offset) * 100) / 100, sorted(missing))
        found = synchronise(ours, theirs)
        assert -1e-3 <= found.offset_s - offset <= 0.011
        assert found.matched >= len(ours) - len(missing) - 3

    def test_pulse_seen_twice_does_no_harm(self):
        ours = pulses_of_a_ride(np.random.default_rng(0))
        theirs = np.sort(np.append(ours, ours[10] + 0.05)) + 3
        assert np.isclose(synchronise(ours, theirs).offset_s, 3, atol=1e-9)

    def test_pulses_all_alike_are_refused(self):
        with pytest.raises(InputError, match="constant speed"):
            synchronise(np.arange(20) * 0.2, np.arange(19) * 0.2 + 5)

    def test_unrelated_pulses_are_refused(self):
        rng = np.random.default_rng(1)
        with pytest.raises(InputError, match="no one offset"):
            synchronise(np.sort(rng.uniform(0, 100, 4)), np.sort(rng.uniform(0, 100, 4)))

    def test_a_long_ride_needs_little_memory_and_time(self):
        """Thirteen minutes: all pairs would be 16 million numbers of 8 bytes, several times."""
        import tracemalloc

        steps = 0.2 + 0.05 * np.sin(np.arange(4000) / 50)
        ours = np.cumsum(steps + np.random.default_rng(0).normal(0, 0.002, 4000))
        tracemalloc.start()
        found = synchronise(ours, np.ceil((ours + 12.3) * 100) / 100)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert found.matched == 4000 and abs(found.offset_s - 12.305) < 1e-3
        assert peak < 200e6

    @given(
        ours=st.lists(st.integers(0, 300), min_size=3, max_size=25),
        theirs=st.lists(st.integers(0, 300), min_size=3, max_size=25),
        tolerance=st.sampled_from([0.001, 0.02, 0.1]),
    )
    def test_same_answer_as_counting_all_pairs(self, ours, theirs, tolerance):
        """Times on a grid of 10 ms, with ties and pulses seen twice."""
        ours, theirs = np.sort(ours) / 100, np.sort(theirs) / 100
        proposed = np.sort((theirs[:, None] - ours).ravel())
        ends = np.searchsorted(proposed, proposed + tolerance, side="right")
        votes = ends - np.arange(len(proposed))
        best = int(np.argmax(votes))
        offset = float(np.median(proposed[best : ends[best]]))
        rival = votes[np.abs(proposed - offset) > 2 * tolerance].max(initial=0)
        if votes[best] < 3 or rival >= votes[best]:
            words = f"{votes[best]} of {len(ours)} pulses match at .*, {rival} at another"
            with pytest.raises(InputError, match=words):
                synchronise(ours, theirs, tolerance_s=tolerance)
        else:
            found = synchronise(ours, theirs, tolerance_s=tolerance)
            assert found == (offset, votes[best])

    def test_the_smallest_offset_of_all_pairs_may_be_the_one(self):
        """The first of ours and the last of theirs: nothing is proposed before it."""
        ours = np.array([0.0, 10.0, 10.004])
        theirs = np.array([2.0, 2.005, 50.0])
        assert synchronise(ours, theirs) == pytest.approx((-7.9995, 4))

    def test_blocks_of_proposals_have_no_seams(self, monkeypatch):
        """Pairs are put in order block by block: the answer does not depend on their length."""
        rng = np.random.default_rng(4)
        ours = pulses_of_a_ride(rng, 40)
        theirs = np.sort(np.r_[ours + 3, rng.uniform(0, 12, 30)])
        whole = synchronise(ours, theirs)
        for length in (1, 7, 100, 1000):
            monkeypatch.setattr(module, "PAIRS_IN_ORDER", length)
            assert synchronise(ours, theirs) == whole

    def test_of_windows_that_fit_alike_the_first_counts_in_whatever_blocks(self, monkeypatch):
        """Offsets 5.000, 5.010, 5.018, 5.025 s: two windows of 20 ms have three of them."""
        ours, theirs = [0.0, 1.0, 3.0, 7.0], np.array([5.0, 6.01, 8.018, 12.025])
        for length, later in ((100, 0.0), (1, 0.0), (1, -20.0)):
            monkeypatch.setattr(module, "PAIRS_IN_ORDER", length)
            assert synchronise(ours, theirs + later) == pytest.approx((5.01 + later, 3))

    def test_a_pulse_that_is_30_ms_late_is_another_one(self):
        """By default: two intervals of a logger at 100 Hz are allowed."""
        ours = pulses_of_a_ride(np.random.default_rng(0))
        late = 0.03 * (np.arange(len(ours)) % 5 == 0)
        assert synchronise(ours, ours + late + 3).matched == np.sum(late == 0)

    @pytest.mark.parametrize("tolerance", [0, -1, np.nan, "0.02"])
    def test_bad_tolerance(self, tolerance):
        with pytest.raises(InputError, match="tolerance_s"):
            synchronise([1.0, 2.0, 3.0], [1.0, 2.0, 3.0], tolerance_s=tolerance)

    def test_times_in_another_unit_are_refused(self):
        with pytest.raises(InputError, match="are the times in s"):
            synchronise([1.0, 2.0, 1e12], [1.0, 2.0, 3.0])

    def test_too_few_pulses(self):
        with pytest.raises(InputError, match="expected at least 3"):
            synchronise([1.0, 2.0], [1.0, 2.0, 3.0])


def test_reference_is_brought_to_our_clock():
    time_s = np.arange(0, 5, 0.01)
    theirs = np.arange(-1, 7, 0.02)
    wires = np.column_stack([np.sin(theirs - 2.5), theirs])
    out = reference_angles(time_s, theirs, wires, 2.5)
    assert np.allclose(out[:400, 0], np.sin(time_s[:400]), atol=1e-4)
