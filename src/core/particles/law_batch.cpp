#include "core/data/processor.hpp"
#include "core/material/laws.hpp"
#include "core/particles/law_batch_of.hpp"
#include "core/scene_spec.hpp"

namespace moraine {

template <class Real, int Dim>
std::unique_ptr<LawBatch<Real, Dim>> MORAINE_ENTRY(make_law_batch)(const MaterialSpec& spec) {
    return with_law<Real>(spec.law, spec.parameters.data(),
                          [&](const auto& law) -> std::unique_ptr<LawBatch<Real, Dim>> {
                              using Law = std::decay_t<decltype(law)>;
                              return std::make_unique<LawBatchOf<Law, Real, Dim>>(law, spec.density);
                          });
}

template std::unique_ptr<LawBatch<float, 2>> MORAINE_ENTRY(make_law_batch)<float, 2>(const MaterialSpec&);
template std::unique_ptr<LawBatch<float, 3>> MORAINE_ENTRY(make_law_batch)<float, 3>(const MaterialSpec&);
template std::unique_ptr<LawBatch<double, 2>> MORAINE_ENTRY(make_law_batch)<double, 2>(const MaterialSpec&);
template std::unique_ptr<LawBatch<double, 3>> MORAINE_ENTRY(make_law_batch)<double, 3>(const MaterialSpec&);

}  // namespace moraine
