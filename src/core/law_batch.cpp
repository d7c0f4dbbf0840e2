#include "core/law_batch.hpp"

#include "core/lanes.hpp"

namespace moraine {

namespace {

template <class Law, class Real, int Dim>
class LawBatchOf final : public LawBatch<Real, Dim> {
  public:
    LawBatchOf(const Law& law, double density) : law_(law), inverse_density_(static_cast<Real>(1 / density)) {}

    void update(const ParticleView<Real, Dim>& p, const std::uint32_t* slots, const Mat<Real, Dim>* gradients, int n,
                Real dt, const std::uint16_t* material_of, int mine, BlockOutcome& out) const override {
        using L = Lanes<Real>;
        std::uint32_t slot[L::count];
        int filled = 0;
        Mat<L, Dim> dL = zero_mat<L, Dim>();
        for (int k = 0; k < n; ++k) {
            if (!material_of || material_of[p.body[slots[k]]] == mine) {
                for (int i = 0; i < Dim; ++i)
                    for (int j = 0; j < Dim; ++j) dL(i, j)[filled] = gradients[k](i, j);
                slot[filled++] = slots[k];
            }
            if (filled == L::count || (k == n - 1 && filled > 0)) {
                update_lanes(p, slot, dL, filled, dt, out);
                filled = 0;
            }
        }
    }

    void begin(const BodyStart& start, const ParticleView<Real, Dim>& p, std::uint32_t slot) const override {
        PointState<Real, Dim> state = load_point<Law>(p, slot);
        begin_point(law_, start, state);
        for (int k = 0; k < Law::history; ++k) p.history[k][slot] = state.history[k];
    }

    double strain_energy(const ParticleView<Real, Dim>& p, std::uint32_t slot) const override {
        return static_cast<double>(law_.strain_energy(load_point<Law>(p, slot))) * static_cast<double>(p.volume[slot]);
    }

    double signal(const ParticleView<Real, Dim>& p, std::uint32_t slot) const override {
        const Real J = std::exp(p.ln_J[slot]);
        return static_cast<double>(signal_speed(law_, load_point<Law>(p, slot), p.velocity[slot], J, inverse_density_));
    }

  private:
    void update_lanes(const ParticleView<Real, Dim>& p, const std::uint32_t* slot, const Mat<Lanes<Real>, Dim>& dL,
                      int n, Real dt, BlockOutcome& out) const {
        StrainIncrement<Lanes<Real>, Dim> all = strain_increment(dL, Lanes<Real>(double(dt)));
        for (int k = 0; k < n; ++k) {
            StrainIncrement<Real, Dim> one;
            for (int c = 0; c < Sym<Real, Dim>::size; ++c)
                one.strain[c] = all.strain[c][k], one.middle[c] = all.middle[c][k];
            for (int i = 0; i < Dim; ++i)
                for (int j = 0; j < Dim; ++j)
                    one.rotation(i, j) = all.rotation(i, j)[k], one.gradient(i, j) = all.gradient(i, j)[k];
            one.volumetric = all.volumetric[k];
            one.stretch = all.stretch[k];
            one.dt = dt;
            update_point(law_, p, slot[k], one, inverse_density_, out);
        }
    }
    Law law_;
    Real inverse_density_;
};

}  // namespace

template <class Real, int Dim>
std::unique_ptr<LawBatch<Real, Dim>> make_law_batch(const MaterialSpec& spec) {
    return with_law<Real>(spec.law, spec.parameters.data(),
                          [&](const auto& law) -> std::unique_ptr<LawBatch<Real, Dim>> {
                              using Law = std::decay_t<decltype(law)>;
                              return std::make_unique<LawBatchOf<Law, Real, Dim>>(law, spec.density);
                          });
}

template std::unique_ptr<LawBatch<float, 2>> make_law_batch<float, 2>(const MaterialSpec&);
template std::unique_ptr<LawBatch<float, 3>> make_law_batch<float, 3>(const MaterialSpec&);
template std::unique_ptr<LawBatch<double, 2>> make_law_batch<double, 2>(const MaterialSpec&);
template std::unique_ptr<LawBatch<double, 3>> make_law_batch<double, 3>(const MaterialSpec&);

}  // namespace moraine
