"""Order, Richardson value and error bar: of sequences that were made for it, and of sums and steps with exact results."""
import json
import lzma
import math
import pathlib
import random
import unittest

from moraine.richardson import estimate, observed_order

COMPUTED = pathlib.Path(__file__).with_name("computed_ladders.json.xz")  # benchmarks/converge/run at 191305bd192e: [[cells, [[exact, [values, ...]], ...]], ...]
LADDERS = [(4.0, 3.0, 2.0), (12.0, 8.0, 6.0), (4.0, 2.0, 1.0)]  # of which the last three of 2:3:4, 3:4:6 and halving are


def computed_ladders():
    """(cells, exact value, values) of what the program computed of problems with exact solutions."""
    for cells, problems in json.loads(lzma.decompress(COMPUTED.read_bytes())):
        for exact, ladders in problems:
            for values in ladders:
                yield cells, exact, values


def trapezoidal(f, a, b, n):
    h = (b - a) / n
    return h * (0.5 * f(a) + sum(f(a + k * h) for k in range(1, n)) + 0.5 * f(b))


def left_sum(f, a, b, n):
    return (b - a) / n * sum(f(a + k * (b - a) / n) for k in range(n))


def euler(f, end, n):
    y = 1.0
    for k in range(n):
        y += end / n * f(k * end / n, y)
    return y


def midpoint_steps(f, end, n):
    y, h = 1.0, end / n
    for k in range(n):
        y += h * f((k + 0.5) * h, y + 0.5 * h * f(k * h, y))
    return y


def solved_problems():
    """(values by number of cells, exact value): 4 ways of computing, each of many integrals or equations."""
    for w in (0.5, 0.9, 1.3, 1.7, 2.1, 2.6, 3.1):
        for c in (-0.5, 0.0, 0.7, 1.4):
            def f(x, w=w, c=c):
                return math.sin(w * x + c) + math.exp(-w * x)

            def primitive(x, w=w, c=c):
                return -math.cos(w * x + c) / w - math.exp(-w * x) / w
            for rule in (trapezoidal, left_sum):
                yield (lambda n, rule=rule, f=f: rule(f, 0.0, 2.0, n)), primitive(2.0) - primitive(0.0)
            rate = -w * (1 + 0.3 * c)
            for step in (euler, midpoint_steps):
                yield (lambda n, step=step, rate=rate: step(lambda t, y: rate * y, 2.0, n)), math.exp(2.0 * rate)


class Richardson(unittest.TestCase):
    def contained(self, found, exact):
        return abs(found.finest - exact) <= found.error

    def test_order_and_value_of_a_pure_power_are_found_whatever_the_ratios(self):
        for cells in LADDERS + [(1.0, 0.7, 0.6)]:
            for p in (0.3, 0.5, 1.0, 1.7, 2.0, 3.5):
                found = estimate(cells, [-7.0 + 0.3 * h**p for h in cells])
                self.assertAlmostEqual(found.order, p, places=6)
                self.assertAlmostEqual(found.value, -7.0, places=8)
                self.assertTrue(self.contained(found, -7.0))

    def test_bars_hold_95_percent_of_made_sequences_with_a_second_term(self):
        chance, held, count = random.Random(7), 0, 0
        for _ in range(3000):
            cells, p = chance.choice(LADDERS), chance.choice((0.5, 1.0, 1.5, 2.0))
            scale = cells[-1] * chance.uniform(2, 40)  # of the solution
            second, exact = chance.uniform(-1, 1), chance.uniform(-5, 5)
            found = estimate(cells, [exact + (h / scale)**p + second * (h / scale)**(p + 1) for h in cells])
            if found.verdict == "converges":
                count += 1
                held += self.contained(found, exact)
        self.assertGreater(count, 2800)
        self.assertGreaterEqual(held / count, 0.95)

    def test_bars_hold_95_percent_of_sums_and_steps_with_exact_results(self):
        held = count = 0
        for value, exact in solved_problems():
            for numbers in ((8, 12, 16), (12, 16, 24), (16, 32, 64), (6, 12, 24)):
                found = estimate([1 / n for n in numbers], [value(n) for n in numbers])
                if found.verdict == "converges":
                    count += 1
                    held += self.contained(found, exact)
        self.assertGreater(count, 400)
        self.assertGreaterEqual(held / count, 0.95)

    def test_bars_hold_95_percent_of_what_the_program_computed_of_exact_problems(self):
        held = count = 0
        for cells, exact, values in computed_ladders():
            found = estimate(cells, values)
            if found.verdict == "converges":
                count += 1
                held += self.contained(found, exact)
        self.assertGreater(count, 2000)
        self.assertGreaterEqual(held / count, 0.95)

    def test_what_does_not_converge_has_no_bar(self):
        for values, verdict in (([1.0, 2.0, 1.5], "oscillates"), ([1.0, 2.0, 4.0], "diverges"), ([1.0, 2.0, 3.0], "diverges"),
                                ([3.0, math.nan, 1.0], "diverges"), ([1.0, 1.0, 2.0], "diverges"), ([2.0, 1.0, 1.0], "stalls"),
                                ([2.0], "too few"), ([1.0, 2.0], "too few")):
            found = estimate([4.0, 2.0, 1.0][-len(values):], values)
            self.assertEqual((found.verdict, found.order, found.error, found.relative), (verdict, None, None, None), values)
        self.assertIsNone(observed_order([4.0, 3.0, 2.0], [0.0, 1.0, 2.42]))  # ln 3/2 over ln 4/3 is 1.409: order 0
        self.assertGreater(observed_order([4.0, 3.0, 2.0], [0.0, 1.0, 2.40]), 0)

    def test_what_is_the_same_but_for_rounding_is_said(self):
        found = estimate([4.0, 3.0, 2.0], [0.1 + 0.2, 0.3, 0.3], resolution=0.01)
        self.assertEqual((found.verdict, found.error), ("equal", 0.01))

    def test_a_counted_value_is_known_to_its_count_at_best(self):
        cells = [4.0, 2.0, 1.0]
        plain, counted = (estimate(cells, [10 + h for h in cells], resolution) for resolution in (0.0, 0.5))
        self.assertAlmostEqual(counted.error - plain.error, 0.5)

    def test_only_the_finest_three_count(self):
        cells = [8.0, 4.0, 2.0, 1.0]
        self.assertEqual(estimate(cells, [99.0, 5.0, 3.0, 2.0]), estimate(cells[1:], [5.0, 3.0, 2.0]))
