"""Tests the rules of simulate_autoscaler.py against Kubernetes' documentation and the cases of its controller's own tests.

    python3 -m unittest discover --start-directory deploy

Sources: the pages "Horizontal Pod Autoscaling" and "HorizontalPodAutoscaler Walkthrough" of kubernetes.io; KEP-853 (configurable scale
velocity), user stories 1 to 5; pkg/controller/podautoscaler/replica_calculator_test.go.
"""

import unittest

from simulate_autoscaler import Behaviour, desired_replicas, manifest_of, simulate


def followed(behaviour, current, wanted, every_s, times):
    """Replicas when the same number is wanted at each sync."""
    numbers = [current]
    for turn in range(times):
        numbers.append(behaviour.next(turn * every_s, numbers[-1], wanted))
    return numbers


class DesiredReplicas(unittest.TestCase):
    def test_twice_the_desired_value_doubles_and_half_of_it_halves(self):
        self.assertEqual(desired_replicas(3, [200] * 3, 0, 0, 100, 100), 6)
        self.assertEqual(desired_replicas(4, [50] * 4, 0, 0, 100, 100), 2)

    def test_a_ratio_within_a_tenth_of_one_changes_nothing(self):
        self.assertEqual([desired_replicas(10, [usage] * 10, 0, 0, 100, 100) for usage in (90, 100, 110, 111, 89)], [10, 10, 10, 12, 9])

    def test_the_walkthrough_goes_from_one_to_seven(self):
        self.assertEqual(desired_replicas(1, [610], 0, 0, 200, 50), 7)

    def test_the_controllers_own_cases(self):
        self.assertEqual(desired_replicas(3, [300, 500, 700], 0, 0, 1000, 30), 5)
        self.assertEqual(desired_replicas(5, [100, 300, 500, 250, 250], 0, 0, 1000, 50), 3)

    def test_pods_that_are_not_ready_count_as_idle_when_more_are_wanted(self):
        self.assertEqual(desired_replicas(3, [500, 700], 1, 0, 1000, 30), 4)

    def test_pods_that_are_not_ready_do_not_turn_the_direction(self):
        self.assertEqual(desired_replicas(3, [400], 2, 0, 1000, 30), 3)

    def test_pods_without_metrics_count_as_busy_when_fewer_are_wanted(self):
        self.assertEqual(desired_replicas(4, [400, 95], 0, 2, 1000, 100), 3)


class Policies(unittest.TestCase):
    def test_the_larger_of_four_pods_and_a_tenth_goes_in_a_minute(self):
        policies = [{"type": "Pods", "value": 4, "periodSeconds": 60}, {"type": "Percent", "value": 10, "periodSeconds": 60}]
        behaviour = Behaviour({"scaleDown": {"policies": policies, "stabilizationWindowSeconds": 0}}, 1, 100)
        numbers = followed(behaviour, 80, 10, 60, 14)
        self.assertEqual(numbers[:4], [80, 72, 64, 57])
        self.assertEqual(numbers[6:], [40, 36, 32, 28, 24, 20, 16, 12, 10])

    def test_nine_times_as_many_may_be_added_in_a_minute(self):
        behaviour = Behaviour({"scaleUp": {"policies": [{"type": "Percent", "value": 900, "periodSeconds": 60}]}}, 1, 1000)
        self.assertEqual(followed(behaviour, 1, 1000, 60, 3), [1, 10, 100, 1000])

    def test_one_pod_may_be_added_in_five_minutes(self):
        behaviour = Behaviour({"scaleUp": {"policies": [{"type": "Pods", "value": 1, "periodSeconds": 300}]}}, 1, 10)
        self.assertEqual(followed(behaviour, 1, 10, 150, 6), [1, 2, 2, 3, 3, 4, 4])

    def test_a_direction_can_be_disabled(self):
        self.assertEqual(followed(Behaviour({"scaleDown": {"selectPolicy": "Disabled"}}, 1, 10), 8, 2, 600, 3), [8] * 4)

    def test_the_largest_recommendation_of_ten_minutes_holds(self):
        rules = {"stabilizationWindowSeconds": 600, "policies": [{"type": "Pods", "value": 5, "periodSeconds": 60}]}
        behaviour, number, numbers = Behaviour({"scaleDown": rules}, 1, 100), 10, []
        for minute, wanted in enumerate([10, 9, 8, 9, 9, 8, 9, 8, 9, 8, 7], start=1):
            number = behaviour.next(60 * minute, number, wanted)
            numbers.append(number)
        self.assertEqual(numbers, [10] * 10 + [9])

    def test_without_policies_four_pods_or_twice_as_many_are_added_in_fifteen_seconds(self):
        self.assertEqual(followed(Behaviour({}, 1, 100), 1, 50, 15, 4), [1, 5, 10, 20, 40])


class Simulation(unittest.TestCase):
    def test_overlays_change_what_they_patch(self):
        base, production, development = (manifest_of(name) for name in ("base", "production", "development"))
        self.assertEqual((base.least, base.most, base.target, base.request_cores, base.limit_cores), (2, 6, 70, 1.0, 2.0))
        self.assertEqual((production.least, production.most), (3, 24))
        self.assertEqual((development.most, development.request_cores), (1, 0.1))

    def test_the_usual_load_changes_nothing(self):
        outcome = simulate(manifest_of("base"), 1.0, 0.5, 5.0, 0.1, 5.1)
        self.assertEqual((outcome.replicas, outcome.shed), ([(0.0, 2)], 0.0))

    def test_twice_the_load_doubles_the_replicas_and_sheds_nothing(self):
        outcome = simulate(manifest_of("base"), 2.0, 0.5, 5.0, 0.1, 5.1)
        self.assertEqual((max(number for _, number in outcome.replicas), outcome.shed), (4, 0.0))
        self.assertEqual(outcome.replicas[-1][1], 2)

    def test_load_beyond_the_most_replicas_is_lost(self):
        # 14 cores of work for 6 pods of 2: a seventh has no answer, and more while pods start.
        outcome = simulate(manifest_of("base"), 10.0, 0.5, 5.0, 0.1, 5.1)
        self.assertGreater(outcome.lost / outcome.arrived, 1 / 7)
        self.assertLess(outcome.lost / outcome.arrived, 1 / 5)


if __name__ == "__main__":
    unittest.main()
