#include <cstdlib>
#include <string_view>

#include "core/data/processor.hpp"
#include "core/material/laws.hpp"
#include "core/scene_spec.hpp"
#include "core/transfer/kernel_list.hpp"

namespace moraine {

namespace {

bool find_avx512() {
#if defined(MORAINE_HAS_AVX512)
    const char* words = std::getenv("MORAINE_AVX512");
    if (words && std::string_view(words) == "0") return false;
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("fma");
#else
    return false;
#endif
}

template <class Real, int Dim, class Shape>
TransferKernels<Real, Dim> choose_processor(bool affine) {
#if defined(MORAINE_HAS_AVX512)
    if constexpr (std::is_same_v<Shape, Quadratic>)
        if (uses_avx512()) return transfer_kernels_avx512<Real, Dim, Shape>(affine);
#endif
    return transfer_kernels_any<Real, Dim, Shape>(affine);
}

}  // namespace

bool uses_avx512() {
    static const bool found = find_avx512();
    return found;
}

template <class Real, int Dim>
TransferKernels<Real, Dim> choose_kernels(Shape shape, bool affine) {
    switch (shape) {
        case Shape::linear:
            return choose_processor<Real, Dim, Linear>(affine);
        case Shape::quadratic:
            return choose_processor<Real, Dim, Quadratic>(affine);
        case Shape::cubic:
            return choose_processor<Real, Dim, Cubic>(affine);
        default:
            return choose_processor<Real, Dim, Gimp>(affine);
    }
}

template <class Real, int Dim>
std::unique_ptr<LawBatch<Real, Dim>> make_law_batch(const MaterialSpec& spec) {
    if (const LawInfo& law = *find_law(spec.law); law.of_file())
        return std::unique_ptr<LawBatch<Real, Dim>>(static_cast<LawBatch<Real, Dim>*>(
            law.file.make_batch(sizeof(Real), Dim, spec.parameters.data(), spec.density)));
#if defined(MORAINE_HAS_AVX512)
    if (uses_avx512()) return make_law_batch_avx512<Real, Dim>(spec);
#endif
    return make_law_batch_any<Real, Dim>(spec);
}

template TransferKernels<float, 2> choose_kernels<float, 2>(Shape, bool);
template TransferKernels<float, 3> choose_kernels<float, 3>(Shape, bool);
template TransferKernels<double, 2> choose_kernels<double, 2>(Shape, bool);
template TransferKernels<double, 3> choose_kernels<double, 3>(Shape, bool);
template std::unique_ptr<LawBatch<float, 2>> make_law_batch<float, 2>(const MaterialSpec&);
template std::unique_ptr<LawBatch<float, 3>> make_law_batch<float, 3>(const MaterialSpec&);
template std::unique_ptr<LawBatch<double, 2>> make_law_batch<double, 2>(const MaterialSpec&);
template std::unique_ptr<LawBatch<double, 3>> make_law_batch<double, 3>(const MaterialSpec&);

}  // namespace moraine
