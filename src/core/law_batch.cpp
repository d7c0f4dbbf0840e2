#include "core/law_batch.hpp"

namespace moraine {

namespace {

template <class Law, class Real, int Dim>
class LawBatchOf final : public LawBatch<Real, Dim> {
  public:
    LawBatchOf(const Law& law, double density) : law_(law), inverse_density_(static_cast<Real>(1 / density)) {}

    void update(const ParticleView<Real, Dim>& p, const std::uint32_t* slots, const Mat<Real, Dim>* gradients, int n,
                Real dt, const std::uint16_t* material_of, int mine, BlockOutcome& out) const override {
        for (int k = 0; k < n; ++k)
            if (!material_of || material_of[p.body[slots[k]]] == mine)
                update_point(law_, p, slots[k], gradients[k], dt, inverse_density_, out);
    }

    double strain_energy(const ParticleView<Real, Dim>& p, std::uint32_t slot) const override {
        return static_cast<double>(law_.strain_energy(load_point<Law>(p, slot))) * static_cast<double>(p.volume[slot]);
    }

    double signal(const ParticleView<Real, Dim>& p, std::uint32_t slot) const override {
        const Real J = std::exp(p.ln_J[slot]);
        return static_cast<double>(signal_speed(law_, load_point<Law>(p, slot), p.velocity[slot], J, inverse_density_));
    }

  private:
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
