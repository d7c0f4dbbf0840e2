#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "core/structures/structure_set.hpp"
#include "structure_scene.hpp"

using namespace moraine;

namespace {

constexpr double pi = 3.14159265358979323846;

StructureSpec spec_of(StructureShape shape) {
    StructureSpec s;
    s.shape = shape;
    s.point = {0.2, -0.1, 0.3};
    s.normal = {1, 2, -0.5};
    s.center = {0.3, -0.2, 0.1};
    s.radius = 0.4;
    s.from = {-0.5, 0.1, -0.2};
    s.to = {0.6, 0.5, 0.4};
    s.min = {-0.5, -0.3, -0.6};
    s.max = {0.7, 0.4, 0.5};
    s.points = {{-0.6, -0.5}, {0.1, -0.1}, {0.7, -0.6}, {0.4, 0.6}};  // not convex
    return s;
}

constexpr StructureShape shapes[] = {StructureShape::plane, StructureShape::sphere,  StructureShape::cylinder,
                                     StructureShape::box,   StructureShape::capsule, StructureShape::polygon};

template <int Dim>
class Placed {
  public:
    explicit Placed(const StructureSpec& spec) : scene_(scene_with(Dim, spec)), set_(scene_) {}

    Surface<Dim> operator()(const Vec<double, Dim>& x) const {
        const ContactField<Dim> f = set_.field();
        return surface(f.structure[0], f.corners, x);
    }

  private:
    Scene scene_;
    StructureSet<Dim> set_;
};

template <int Dim>
Vec<double, Dim> random_place(std::mt19937& random) {
    std::uniform_real_distribution<double> place(-1.5, 1.5);
    Vec<double, Dim> x;
    for (int a = 0; a < Dim; ++a) x[a] = place(random);
    return x;
}

template <int Dim, class F>
void each_shape(const F& f) {
    for (StructureShape shape : shapes) {
        if (Dim == 2 && shape == StructureShape::cylinder) continue;
        CAPTURE(int(shape));
        f(Placed<Dim>(spec_of(shape)));
    }
}

template <int N>
struct Dimension {
    static constexpr int dim = N;
};

}  // namespace

TYPE_TO_STRING_AS("2-D", Dimension<2>);
TYPE_TO_STRING_AS("3-D", Dimension<3>);

TEST_CASE_TEMPLATE("going back by the distance along the normal ends on the surface", D, Dimension<2>, Dimension<3>) {
    constexpr int dim = D::dim;
    std::mt19937 random(1);
    each_shape<dim>([&](const Placed<dim>& shape) {
        for (int k = 0; k < 400; ++k) {
            const Vec<double, dim> x = random_place<dim>(random);
            const Surface<dim> s = shape(x);
            REQUIRE(magnitude(s.normal) == doctest::Approx(1).epsilon(1e-12));
            const Vec<double, dim> foot = x - s.distance * s.normal;
            CAPTURE(s.distance);
            REQUIRE(std::fabs(shape(foot).distance) < 1e-12);
        }
    });
}

TEST_CASE_TEMPLATE("no way changes the distance by more than its length, and the normal is its gradient", D,
                   Dimension<2>, Dimension<3>) {
    constexpr int dim = D::dim;
    std::mt19937 random(2);
    each_shape<dim>([&](const Placed<dim>& shape) {
        int smooth = 0;
        for (int k = 0; k < 400; ++k) {
            const Vec<double, dim> x = random_place<dim>(random), y = random_place<dim>(random);
            const Surface<dim> at_x = shape(x);
            REQUIRE(std::fabs(at_x.distance - shape(y).distance) <= magnitude(x - y) + 1e-12);
            Vec<double, dim> slope;
            for (int a = 0; a < dim; ++a) {
                Vec<double, dim> ahead = x, behind = x;
                ahead[a] += 1e-6, behind[a] -= 1e-6;
                slope[a] = (shape(ahead).distance - shape(behind).distance) / 2e-6;
            }
            if (std::fabs(magnitude(slope) - 1) < 1e-6) {
                ++smooth;
                REQUIRE(magnitude(slope - at_x.normal) < 1e-5);
            }
        }
        CHECK(smooth > 350);
    });
}

TEST_CASE("the volume where the distance is negative is that of the shape") {
    const double length_of_axis = std::sqrt(1.1 * 1.1 + 0.4 * 0.4 + 0.6 * 0.6);
    const double polygon = 0.5 * std::fabs(-0.6 * -0.1 - 0.1 * -0.5 + 0.1 * -0.6 - 0.7 * -0.1 + 0.7 * 0.6 - 0.4 * -0.6 +
                                           0.4 * -0.5 - -0.6 * 0.6);
    const std::pair<StructureShape, double> volumes[] = {
        {StructureShape::sphere, 4.0 / 3 * pi * 0.064},
        {StructureShape::cylinder, pi * 0.16 * length_of_axis},
        {StructureShape::box, 1.2 * 0.7 * 1.1},
        {StructureShape::capsule, pi * 0.16 * length_of_axis + 4.0 / 3 * pi * 0.064},
        {StructureShape::polygon, polygon * 1.1}};
    for (const auto& [shape, volume] : volumes) {
        const Placed<3> distance(spec_of(shape));
        std::int64_t inside = 0;
        const int n = 120;
        for (int i = 0; i < n * n * n; ++i) {
            const Vec<double, 3> x{
                {-1.5 + 3 * (i % n + 0.5) / n, -1.5 + 3 * (i / n % n + 0.5) / n, -1.5 + 3 * (i / n / n + 0.5) / n}};
            inside += distance(x).distance < 0;
        }
        CAPTURE(int(shape));
        CHECK(double(inside) * 27 / (double(n) * n * n) == doctest::Approx(volume).epsilon(0.01));
    }
}

TEST_CASE("a polygon is the same structure whichever way its corners are listed") {
    StructureSpec spec = spec_of(StructureShape::polygon);
    const Placed<2> one(spec);
    std::reverse(spec.points.begin(), spec.points.end());
    const Placed<2> other(spec);
    std::mt19937 random(3);
    for (int k = 0; k < 200; ++k) {
        const auto x = random_place<2>(random);
        REQUIRE(one(x).distance == doctest::Approx(other(x).distance).epsilon(1e-12));
    }
}

namespace {

StructureSpec polygon_of(std::vector<std::array<double, 2>> points) {
    StructureSpec spec = spec_of(StructureShape::polygon);
    spec.points = std::move(points);
    spec.min[2] = -1, spec.max[2] = 1;
    return spec;
}

}  // namespace

TEST_CASE("on an edge of a polygon the normal is the edge's, to either side of rounding") {
    for (const double beside : {0.0, 1e4}) {
        const Placed<2> slope(polygon_of({{beside, 2}, {beside + 4, 0}, {beside + 4, -1}, {beside, -1}}));
        const double length = std::sqrt(5.0);
        for (int k = 1; k < 20; ++k) {
            const double x = beside + 0.2 * k, off = (k % 3 - 1) * 1e-13;
            const Surface<2> s = slope({{x, 2 - 0.1 * k + off}});
            CAPTURE(k);
            REQUIRE(std::fabs(s.distance) < 1e-11);
            REQUIRE(s.normal[0] == doctest::Approx(1 / length).epsilon(1e-10));
            REQUIRE(s.normal[1] == doctest::Approx(2 / length).epsilon(1e-10));
        }
    }
}

TEST_CASE("where two edges are equally near the normal is their mean, in any order of the corners") {
    std::vector<std::array<double, 2>> points{{-0.7, -0.9}, {0.7, -0.9}, {0.3, 0.4}, {0, 0.8}, {-0.3, 0.4}};
    for (std::size_t turn = 0; turn < 2 * points.size(); ++turn) {
        if (turn == points.size()) std::reverse(points.begin(), points.end());
        std::rotate(points.begin(), points.begin() + 1, points.end());
        const Placed<2> wedge(polygon_of(points));
        for (double y : {0.8, 0.7, 0.61, 0.3}) {
            CAPTURE(turn);
            CAPTURE(y);
            const Surface<2> s = wedge({{0, y}});
            REQUIRE(std::fabs(s.normal[0]) < 1e-12);
            REQUIRE(s.normal[1] == doctest::Approx(1).epsilon(1e-12));
        }
        for (double x : {0.01, 0.2, 0.45}) {
            const Surface<2> right = wedge({{x, 0.5}}), left = wedge({{-x, 0.5}});
            REQUIRE(right.normal[0] == doctest::Approx(-left.normal[0]).epsilon(1e-12));
            REQUIRE(right.normal[1] == doctest::Approx(left.normal[1]).epsilon(1e-12));
        }
    }
}

TEST_CASE("a prism has the normal of its face where a point lies on it, and the mean at its edges") {
    const Placed<3> prism(polygon_of({{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}));
    for (double off : {-1e-14, 0.0, 1e-14}) {
        CHECK(prism({{1 + off, 0.3, 0.2}}).normal[0] == doctest::Approx(1));
        CHECK(prism({{0.1, 0.3, 1 + off}}).normal[2] == doctest::Approx(1));
        const Surface<3> edge = prism({{1 + off, 0.3, 1 + off}}), inner = prism({{0.9, 0.3, 0.9}});
        for (int a : {0, 2}) {
            CHECK(edge.normal[a] == doctest::Approx(std::sqrt(0.5)));
            CHECK(inner.normal[a] == doctest::Approx(std::sqrt(0.5)));
        }
    }
}

TEST_CASE("a point halfway between the sides of a thin polygon has the normal of one of them") {
    const Surface<2> middle = Placed<2>(polygon_of({{-1, -0.1}, {1, -0.1}, {1, 0.1}, {-1, 0.1}}))({{0.2, 0}});
    CHECK(magnitude(middle.normal) == doctest::Approx(1));
    CHECK(middle.distance == doctest::Approx(-0.1));
}

TEST_CASE("a prescribed way is the integral of its velocity, and a step's velocity makes the way exact") {
    StructureSpec spec = spec_of(StructureShape::sphere);
    MotionSpec& m = spec.motion;
    m.velocity = {2, -1, 0};
    m.ramp = 0.4;
    m.amplitude = {0.3, 0, 0};
    m.period = 0.7;
    m.factor.times = {0.1, 0.3, 0.4};
    m.factor.values = {1, -2, 0.5};
    const auto speed = [&](double t) {
        if (m.kind == StructureMotion::velocity) return t < 0.4 ? 1 - std::cos(pi * t / 0.4) : 2.0;
        if (m.kind == StructureMotion::sinusoid) return 0.3 * 2 * pi / 0.7 * std::cos(2 * pi * t / 0.7);
        if (t < 0.1) return 2.0;
        if (t < 0.3) return 2 * (1 - 15 * (t - 0.1));
        return t < 0.4 ? 2 * (-2 + 25 * (t - 0.3)) : 1.0;
    };
    for (StructureMotion kind : {StructureMotion::velocity, StructureMotion::sinusoid, StructureMotion::table}) {
        CAPTURE(int(kind));
        m.kind = kind;
        const Scene scene = scene_with(2, spec);
        StructureSet<2> set(scene);
        double way = 0, t = 0;
        for (int k = 0; k < 1000; ++k) {
            const double dt = 0.0007;
            set.begin_step(t, dt, {}, {}, {});
            way += dt * (speed(t) + 4 * speed(t + dt / 2) + speed(t + dt)) / 6;
            t += dt;
            set.end_step(t, dt);
        }
        CHECK(set.state(0).displacement[0] == doctest::Approx(way).epsilon(1e-6));
        CHECK(displacement_at(m, t)[0] == doctest::Approx(way).epsilon(1e-6));
    }
}

TEST_CASE("a free structure falls by gravity and its force, feels the last impulse, and expects the next one") {
    StructureSpec spec = spec_of(StructureShape::sphere);
    spec.motion.kind = StructureMotion::free;
    spec.motion.mass = 4;
    spec.motion.force = {8, 0, 0};
    spec.motion.velocity = {0, 1, 0};
    Scene scene = scene_with(2, spec);
    scene.gravity = {0, -10, 0};
    StructureSet<2> set(scene);
    const Quantum quantum = Quantum::for_largest(1e3);
    std::vector<StructureSums<2>> felt(1);
    set.begin_step(0, 0.1, {0, -10}, felt, quantum);
    set.end_step(0.1, 0.1);
    CHECK(set.state(0).velocity[0] == doctest::Approx(0.2));
    CHECK(set.state(0).velocity[1] == doctest::Approx(0));
    felt[0].sum[1] = quantum.of(12);
    felt[0].sum[4] = quantum.of(12);  // mass that follows it
    set.begin_step(0.1, 0.1, {0, -10}, felt, quantum);
    set.end_step(0.2, 0.1);
    CHECK(set.state(0).carried[1] == doctest::Approx(2));
    CHECK(set.state(0).displacement[0] == doctest::Approx(0.06));
    CHECK(set.state(0).velocity[1] == doctest::Approx(2 + (12 - 12 * (1.25 - 0)) / 4));  // J* = J' - K (V* - V*')
    StructureSet<2> restarted(scene);
    restarted.states() = set.states();
    restarted.place();
    CHECK(restarted.field().structure[0].velocity[1] == set.state(0).velocity[1]);
}
