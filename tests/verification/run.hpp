#pragma once
// A run over a scene written in code: what one chooses, the particles with the places where they began, sums
// over them, and the time that the steps took. Shared by the tests and by benchmarks/accuracy.
//
// A problem in one direction is a strip of four cells (one block) across, periodic there; one particle
// per cell across is enough, since nothing varies. The exact solutions are in exact_*.hpp, the scenes and what is
// measured in problem_*.hpp.

#include <chrono>
#include <cmath>
#include <ctime>
#include <functional>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "core/material/laws.hpp"
#include "simulation/diagnostics.hpp"

namespace moraine::verification {

inline constexpr double pi = std::numbers::pi;

/// Time of a clock on the wall and of this process's processors [s].
struct Seconds {
    double wall = 0, processor = 0;

    static Seconds now() {
        std::timespec t{};
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
        return {std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(),
                static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec)};
    }
    void add(const Seconds& to, const Seconds& from, double sign = 1) {
        wall += sign * (to.wall - from.wall);
        processor += sign * (to.processor - from.processor);
    }
};

/// What a user may choose for one and the same scene.
struct Choice {
    const char* name;
    Shape shape;
    Transfer transfer;
    StressUpdate update;
    int order = 2;  ///< of FMPM
};

inline constexpr Choice quadratic_flip_usl{"quadratic FLIP USL", Shape::quadratic, Transfer::flip, StressUpdate::usl};
inline constexpr Choice quadratic_flip_musl{"quadratic FLIP MUSL", Shape::quadratic, Transfer::flip,
                                            StressUpdate::musl};
inline constexpr Choice quadratic_apic_usl{"quadratic APIC USL", Shape::quadratic, Transfer::apic, StressUpdate::usl};
inline constexpr Choice quadratic_apic_usf{"quadratic APIC USF", Shape::quadratic, Transfer::apic, StressUpdate::usf};
inline constexpr Choice quadratic_apic_musl{"quadratic APIC MUSL", Shape::quadratic, Transfer::apic,
                                            StressUpdate::musl};
inline constexpr Choice quadratic_aflip_usl{"quadratic AFLIP USL", Shape::quadratic, Transfer::aflip,
                                            StressUpdate::usl};
inline constexpr Choice quadratic_aflip_usf{"quadratic AFLIP USF", Shape::quadratic, Transfer::aflip,
                                            StressUpdate::usf};
inline constexpr Choice quadratic_tpic_usl{"quadratic TPIC USL", Shape::quadratic, Transfer::tpic, StressUpdate::usl};
inline constexpr Choice cubic_flip_usl{"cubic FLIP USL", Shape::cubic, Transfer::flip, StressUpdate::usl};
inline constexpr Choice cubic_apic_usl{"cubic APIC USL", Shape::cubic, Transfer::apic, StressUpdate::usl};
inline constexpr Choice cubic_aflip_usl{"cubic AFLIP USL", Shape::cubic, Transfer::aflip, StressUpdate::usl};
inline constexpr Choice gimp_flip_usl{"gimp FLIP USL", Shape::gimp, Transfer::flip, StressUpdate::usl};
inline constexpr Choice gimp_tpic_usl{"gimp TPIC USL", Shape::gimp, Transfer::tpic, StressUpdate::usl};
inline constexpr Choice contiguous_flip_usl{"gimp-contiguous FLIP USL", Shape::gimp_contiguous, Transfer::flip,
                                            StressUpdate::usl};
inline constexpr Choice contiguous_tpic_usl{"gimp-contiguous TPIC USL", Shape::gimp_contiguous, Transfer::tpic,
                                            StressUpdate::usl};
inline constexpr Choice quadratic_fmpm2{"quadratic FMPM(2)", Shape::quadratic, Transfer::fmpm, StressUpdate::usl, 2};
inline constexpr Choice quadratic_fmpm3{"quadratic FMPM(3)", Shape::quadratic, Transfer::fmpm, StressUpdate::usl, 3};
inline constexpr Choice quadratic_fmpm4{"quadratic FMPM(4)", Shape::quadratic, Transfer::fmpm, StressUpdate::usl, 4};
inline constexpr Choice contiguous_fmpm2{"gimp-contiguous FMPM(2)", Shape::gimp_contiguous, Transfer::fmpm,
                                         StressUpdate::usl, 2};

inline void choose(Scene& scene, const Choice& choice) {
    scene.shape = choice.shape;
    scene.transfer = choice.transfer;
    scene.flip = standard_flip(choice.transfer);
    scene.stress_update = choice.update;
    scene.order = choice.order;
}

/// Values by key, defaults for the rest, in the order of the law's table.
inline MaterialSpec material(const std::string& law, double density, const std::map<std::string, double>& values) {
    MaterialSpec spec;
    spec.name = spec.law = law;
    spec.density = density;
    for (const Parameter& p : find_law(law)->parameters) {
        const auto given = values.find(p.key);
        spec.parameters.push_back(given == values.end() ? p.standard : given->second);
    }
    return spec;
}

inline void make_periodic(Scene& scene, std::size_t axis) {
    scene.periodic[axis] = true;
    for (WallSpec& wall : scene.walls[axis]) wall.kind = WallKind::periodic;
}

/// Where each particle began, by id (one body). Collective.
template <class Real, int Dim>
std::vector<std::array<double, Dim>> places(Simulation<Real, Dim>& sim, const Comm& comm) {
    struct Row {
        std::uint64_t id;
        std::array<double, Dim> x;
    };
    std::vector<Row> rows;
    const ParticleView<Real, Dim> p = sim.patch().particles.view();
    each_particle(sim, [&](std::uint32_t s, const std::array<double, Dim>& x) { rows.push_back({p.id[s], x}); });
    rows = comm.all_gather(rows);
    std::vector<std::array<double, Dim>> by_id;
    for (const Row& row : rows) {
        if (row.id >= by_id.size()) by_id.resize(row.id + 1);
        by_id[row.id] = row.x;
    }
    return by_id;
}

/// A run of one scene that remembers where its particles began.
template <class Real = double, int Dim = 2>
class Run {
  public:
    using Point = std::array<double, Dim>;
    using View = ParticleView<Real, Dim>;
    using BodyForce = std::function<Vec<double, Dim>(const Point& X, double t)>;

    explicit Run(const Scene& scene, const BodyForce& force = {}) : comm_(MPI_COMM_WORLD), sim(scene, comm_) {
        if (force)
            sim.set_body_force([this, force](std::uint64_t id, const Point&, double t) {
                if (calls_++ % X_.size() == 0) force_began_ = Seconds::now();
                const Vec<double, Dim> b = force(X_[id], t);
                if (calls_ % X_.size() == 0) spent_.add(Seconds::now(), force_began_, -1);
                return b;
            });
        sim.seed();
        X_ = places(sim, comm_);
    }

    /// f(particles, slot, X): sets a start that a scene cannot say. Collective.
    template <class F>
    void start_with(const F& f) {
        const View p = view();
        each_particle(sim, [&](std::uint32_t s, const Point&) { f(p, s, X_[p.id[s]]); });
        sim.refresh_signal();
    }

    void steps(std::int64_t n) {
        const Seconds began = Seconds::now();
        for (std::int64_t k = 0; k < n; ++k) {
            sim.step();
            sim.balance();
        }
        sim.conclude();
        spent_.add(Seconds::now(), began);
    }

    /// Sum over all particles of f(particles, slot, X, x). Binned state only. Collective.
    template <class F>
    double sum(const F& f) {
        const View p = view();
        double sum = 0;
        each_particle(sim, [&](std::uint32_t s, const Point& x) { sum += f(p, s, X_[p.id[s]], x); });
        return comm_.sum(sum);
    }

    /// Largest f(particles, slot, X, x). Binned state only. Collective.
    template <class F>
    double largest(const F& f) {
        const View p = view();
        double most = 0;
        each_particle(sim, [&](std::uint32_t s, const Point& x) { most = std::max(most, f(p, s, X_[p.id[s]], x)); });
        return comm_.max(most);
    }

    View view() { return sim.patch().particles.view(); }
    double time() const { return sim.clock().time; }
    std::size_t particles() const { return X_.size(); }
    /// By the steps, without the body force, which is the problem's and not the method's. On one rank.
    const Seconds& spent() const { return spent_; }

  private:
    Comm comm_;
    std::vector<Point> X_;
    Seconds spent_, force_began_;
    std::size_t calls_ = 0;  ///< of the body force

  public:
    Simulation<Real, Dim> sim;
};

/// Observed order between neighbours of a refinement study that halves h.
inline double order(double coarse, double fine) {
    return std::log2(coarse / fine);
}

}  // namespace moraine::verification
