#pragma once
// The scene's materials, as batches of particles that share a law.
//
// The gather hands over slots and velocity gradients; one call per material in the scene updates its
// particles. So a law is compiled once per dimension and precision, whatever the shapes and transfers.

#include <memory>

#include "core/material/point.hpp"
#include "core/particles/stress.hpp"

namespace moraine {

/// One material of the scene, ready for batches.
template <class Real, int Dim>
class LawBatch {
  public:
    virtual ~LawBatch() = default;
    /// Updates the particles whose material is `mine` according to material_of (null: all are).
    virtual void update(const ParticleView<Real, Dim>& p, const std::uint32_t* slots, const Mat<Real, Dim>* gradients,
                        int n, Real dt, const std::uint16_t* material_of, int mine, BlockOutcome& out) const = 0;
    /// Gives a particle that has its stress the law's scalars of the start.
    virtual void begin(const BodyStart& start, const ParticleView<Real, Dim>& p, std::uint32_t slot) const = 0;
    /// Stored elastic energy [J] and signal speed c + |v| [m/s] of one particle.
    virtual double strain_energy(const ParticleView<Real, Dim>& p, std::uint32_t slot) const = 0;
    virtual double signal(const ParticleView<Real, Dim>& p, std::uint32_t slot) const = 0;
};

struct MaterialSpec;

/// For this processor (processor.hpp), and for which it was compiled; a law in a file is for this one. Not collective.
template <class Real, int Dim>
std::unique_ptr<LawBatch<Real, Dim>> make_law_batch(const MaterialSpec& spec);
template <class Real, int Dim>
std::unique_ptr<LawBatch<Real, Dim>> make_law_batch_any(const MaterialSpec& spec);
template <class Real, int Dim>
std::unique_ptr<LawBatch<Real, Dim>> make_law_batch_avx512(const MaterialSpec& spec);

/// Called by the gather: every material of the scene over one batch.
template <class Real, int Dim>
struct HostStress {
    const LawBatch<Real, Dim>* const* laws;
    int count;
    const std::uint16_t* material_of;  ///< by body

    void operator()(const ParticleView<Real, Dim>& p, const std::uint32_t* slots, const Mat<Real, Dim>* gradients,
                    int n, Real dt, BlockOutcome& out) const {
        for (int m = 0; m < count; ++m)
            laws[m]->update(p, slots, gradients, n, dt, count == 1 ? nullptr : material_of, m, out);
    }
};

}  // namespace moraine
