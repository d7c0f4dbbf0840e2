#pragma once
// The loop of one law over a batch of particles, as a template of the law: of the program (law_batch.cpp), or in a file
// (law_object.hpp). What has no branches is done for a register of particles at once.

#include "core/data/lanes.hpp"
#include "core/particles/law_batch.hpp"

namespace moraine {

template <class Law, class Real, int Dim>
class LawBatchOf final : public LawBatch<Real, Dim> {
  public:
    LawBatchOf(const Law& law, double density) : law_(law), inverse_density_(static_cast<Real>(1 / density)) {}

    void update(const ParticleView<Real, Dim>& p, const std::uint32_t* slots, const Mat<Real, Dim>* gradients, int n,
                Real dt, const std::uint16_t* material_of, int mine, BlockOutcome& out) const override {
        int lane_of[L::count];
        int filled = 0;
        for (int k = 0; k < n; ++k) {
            if (!material_of || material_of[p.body[slots[k]]] == mine) lane_of[filled++] = k;
            if (filled == L::count || (k == n - 1 && filled > 0)) {
                for (int i = filled; i < L::count; ++i) lane_of[i] = lane_of[filled - 1];
                update_lanes(p, slots, gradients, lane_of, filled, dt, out);
                filled = 0;
            }
        }
    }

    void begin(const BodyStart& start, const ParticleView<Real, Dim>& p, std::uint32_t slot) const override {
        PointState<Real, Dim> state = load_point(law_, p, slot);
        begin_point(law_, start, state);
        for (int k = 0; k < scalars_of(law_); ++k) p.history[k][slot] = state.history[k];
    }

    double strain_energy(const ParticleView<Real, Dim>& p, std::uint32_t slot) const override {
        return static_cast<double>(law_.strain_energy(load_point(law_, p, slot))) * static_cast<double>(p.volume[slot]);
    }

    double signal(const ParticleView<Real, Dim>& p, std::uint32_t slot) const override {
        const Real J = std::exp(p.ln_J[slot]);
        return static_cast<double>(
            signal_speed(law_, load_point(law_, p, slot), p.velocity[slot], J, inverse_density_));
    }

  private:
    using L = Lanes<Real>;
    /// Whether trials are made in lanes (point.hpp).
    static constexpr bool has_trial =
        requires(const Law& law, const StrainIncrement<Real, Dim>& i, PointState<Real, Dim>& s) {
        law.after_trial(i, s);
    };

    /// And whether the particles have one stiffness, by which that is.
    bool has_one_trial() const {
        if constexpr (requires { law_.has_one_stiffness(); })
            return law_.has_one_stiffness();
        else
            return has_trial;
    }

    /// Updates n particles of a batch: those at lane_of. What has no branches is done for all lanes.
    void update_lanes(const ParticleView<Real, Dim>& p, const std::uint32_t* slots, const Mat<Real, Dim>* gradients,
                      const int* lane_of, int n, Real dt, BlockOutcome& out) const {
        Mat<L, Dim> dL;
        for (int i = 0; i < Dim; ++i)
            for (int j = 0; j < Dim; ++j) dL(i, j) = L::each([&](int k) { return gradients[lane_of[k]](i, j); });
        const StrainIncrement<L, Dim> all = strain_increment(dL, L(double(dt)));
        Sym<L, Dim> trial;
        const bool tries = has_one_trial();
        if constexpr (has_trial) {
            for (int c = 0; tries && c < Sym<L, Dim>::size; ++c)
                trial[c] = L::each([&](int k) { return p.stress[slots[lane_of[k]]][c]; });
            if (tries) trial = law_.elastic.trial(all, trial);
        }
        for (int k = 0; k < n; ++k) {
            const std::uint32_t s = slots[lane_of[k]];
            StrainIncrement<Real, Dim> one = increment_of(all, k);
            one.dt = dt;
            PointState<Real, Dim> state = load_point(law_, p, s);
            if constexpr (has_trial) {
                if (tries) {
                    const Sym<Real, Dim> before = state.stress;
                    for (int c = 0; c < Sym<Real, Dim>::size; ++c) state.stress[c] = trial[c][k];
                    state.ln_J += one.volumetric;
                    law_.after_trial(one, state);
                    store_point(law_, p, s, state,
                                point_step(law_, one, before, state, p.mass[s], p.velocity[s], inverse_density_), out);
                    continue;
                }
            }
            const PointStep<Real> step = advance_point(law_, one, state, p.mass[s], p.velocity[s], inverse_density_);
            store_point(law_, p, s, state, step, out);
        }
    }

    /// That of one lane, but dt.
    static StrainIncrement<Real, Dim> increment_of(const StrainIncrement<L, Dim>& all, int k) {
        StrainIncrement<Real, Dim> one;
        for (int c = 0; c < Sym<Real, Dim>::size; ++c)
            one.strain[c] = all.strain[c][k], one.middle[c] = all.middle[c][k];
        for (int i = 0; i < Dim; ++i)
            for (int j = 0; j < Dim; ++j)
                one.rotation(i, j) = all.rotation(i, j)[k], one.gradient(i, j) = all.gradient(i, j)[k];
        one.volumetric = all.volumetric[k];
        one.stretch = all.stretch[k];
        return one;
    }

    Law law_;
    Real inverse_density_;
};

}  // namespace moraine
