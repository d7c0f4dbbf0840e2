#include <doctest/doctest.h>

#include <atomic>

#include "core/sample.hpp"
#include "core/transfer/g2p.hpp"

using namespace moraine;
using moraine::test::Sample;

namespace {

/// What a gather has asked of a term.
struct Counts {
    std::atomic<int> blocks{0}, cells{0}, rates{0}, stresses{0}, closed{0}, moves{0}, wrong{0};
};

/// A physics of one file: particles are counted, and drift along the first axis.
template <class Real>
struct CountingTerm {
    static constexpr unsigned hooks =
        hook_block | hook_cell | hook_rate | hook_stress | hook_after_cell | hook_velocity;
    Counts* counts;
    Real drift;  ///< [m/s]

    template <class Case>
    struct State {
        int particles;  ///< of the cell
    };

    template <class Of>
    bool on(const Of&) const {
        return counts != nullptr;
    }
    template <class Of, class Case>
    void at_block(const Of&, int, const Quad<Real>*, State<Case>&) const {
        ++counts->blocks;
    }
    template <class Of, class Case, class Gathered>
    void at_cell(const Of&, const CellInWork<Case>&, State<Case>& state, const Gathered&) const {
        ++counts->cells;
        state.particles = 0;
    }
    template <class Of, class Case, class Point>
    void on_rate(const Of&, const CellInWork<Case>&, const Point&, State<Case>& state) const {
        ++counts->rates;
        ++state.particles;
    }
    template <class Of, class Case, class Point, class Rate, class Out>
    void before_stress(const Of&, const CellInWork<Case>&, const Point&, Rate&, State<Case>&, Out& out) const {
        ++counts->stresses;
        out.work += 1;
    }
    template <class Of, class Case, class Rate>
    void after_cell(const Of&, const CellInWork<Case>& cell, const std::uint32_t*, Rate*, int n,
                    State<Case>& state) const {
        ++counts->closed;
        if (state.particles != n || n != int(cell.end - cell.begin)) ++counts->wrong;
    }
    template <class Of, class Case, class Point>
    void on_velocity(const Of&, const CellInWork<Case>&, const Point&, State<Case>&, Quad<Real>& velocity) const {
        ++counts->moves;
        velocity[0] += drift;
    }
};

/// A gather of nodes at rest, with the terms of a scene and one more behind them.
template <class Real, int Dim>
struct Gathering {
    using AllTerms = Terms<LightTerm<Real>, BoxTerm, MeansTerm<Real>, CountingTerm<Real>>;
    using Case = GatherCase<Real, Dim, Quadratic, true>;
    Sample<Real, Dim> sample;
    int occupied_blocks = 0, occupied_cells = 0;

    explicit Gathering(int particles) : sample(scene(), particles, 31) {
        const TileView<Real> grid = sample.patch.grid();
        for (std::int32_t c : sample.patch.node_blocks())
            if (grid.node_of[c] >= 0)
                std::fill_n(grid.nodes + grid.node_of[c] * Block<Dim>::cells * node_reals,
                            Block<Dim>::cells * node_reals, Real(0));
        const ListView<Dim> list = sample.patch.list();
        for (int b = 0; b < sample.patch.own(); ++b) {
            if (list.count(b) > 0) ++occupied_blocks;
            const std::uint32_t* first = list.cell_first + b * (Block<Dim>::cells + 1);
            for (int c = 0; c < Block<Dim>::cells; ++c)
                if (first[c] < first[c + 1]) ++occupied_cells;
        }
    }

    static Scene scene() {
        Scene scene = test::sample_scene(Dim, moraine::Shape::quadratic, true);
        scene.transfer = Transfer::apic;
        return scene;
    }

    void run(unsigned what, Counts* counts, Real drift) {
        const auto call = sample.call();
        const GridToParticles<Case, HostStress<Real, Dim>, AllTerms> kernel{call.context,
                                                                            call.particles,
                                                                            call.table,
                                                                            call.list,
                                                                            call.grid,
                                                                            {nullptr, 0, nullptr},
                                                                            call.chosen,
                                                                            sample.method.ends,
                                                                            sample.round(what, 1),
                                                                            sample.notes(),
                                                                            {{}, {}, {}, {counts, drift}}};
        Host::launch_teams(call.count, kernel);
    }

    double work() {
        double sum = 0;
        for (int b = 0; b < sample.patch.own(); ++b) sum += sample.patch.outcome(b).work;
        return sum;
    }
};

}  // namespace

TYPE_TO_STRING_AS("2-D", std::integral_constant<int, 2>);
TYPE_TO_STRING_AS("3-D", std::integral_constant<int, 3>);

TEST_CASE_TEMPLATE("a term is called once for each block, cell and particle, and tallies what it says", D,
                   std::integral_constant<int, 2>, std::integral_constant<int, 3>) {
    const int particles = 300;
    Gathering<double, D::value> gathering(particles);
    Counts counts;
    gathering.run(gather_gradient | gather_motion, &counts, 0);
    CHECK(counts.blocks == gathering.occupied_blocks);
    CHECK(counts.cells == gathering.occupied_cells);
    CHECK(counts.rates == particles);
    CHECK(counts.stresses == particles);
    CHECK(counts.closed == gathering.occupied_cells);
    CHECK(counts.moves == particles);
    CHECK(counts.wrong == 0);
    CHECK(gathering.work() == particles);
}

TEST_CASE("in a round that takes no gradient nobody's stress is asked for, and a term that is off costs nothing") {
    Gathering<double, 2> gathering(300);
    Counts counts;
    gathering.run(gather_velocity, &counts, 0);
    CHECK(counts.rates == 300);
    CHECK(counts.stresses == 0);
    CHECK(counts.closed == 0);
    CHECK(counts.moves == 0);
    gathering.run(gather_gradient | gather_motion, nullptr, 0);
    CHECK(counts.rates == 300);
    CHECK(gathering.work() == 0);
}

TEST_CASE("what a term adds to a velocity moves the particle") {
    Gathering<double, 2> gathering(300);
    const auto p = gathering.sample.patch.particles.view();
    std::map<std::uint32_t, double> before;
    gathering.sample.each_particle(
        [&](std::uint32_t s, const auto&) { before[s] = fraction_of<double>(p.position[s][0]); });
    Counts counts;
    gathering.run(gather_motion, &counts, 0.125);  // a quarter of a cell
    gathering.sample.each_particle([&](std::uint32_t s, const auto&) {
        const double moved = fraction_of<double>(p.position[s][0]) - before.at(s);
        CHECK(moved - std::floor(moved) == doctest::Approx(0.25));
    });
}
