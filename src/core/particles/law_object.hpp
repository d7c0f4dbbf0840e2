#pragma once
// A law in a file of the user's as an object of its own: all that the program asks of it, behind one entry. Included by
// what compile/law_file.cpp compiles, with the struct `Law` of the file; the loop over particles is that of every law.

#include <cstring>
#include <type_traits>

#include "core/material/law_info.hpp"
#include "core/particles/law_batch_of.hpp"

namespace moraine {

template <class Real>
struct Law;  ///< of the file

namespace detail {

template <class Type>
concept Complete = requires {
    sizeof(Type);
};

template <class F>
auto with_real(int bytes, F&& f) {
    return bytes == sizeof(float) ? f(float{}) : f(double{});
}

template <template <class> class Law>
void* make_law_batch_of(int bytes, int dimension, const double* values, double density) {
    return with_real(bytes, [&]<class Real>(Real) -> void* {
        const Law<Real> law(values);
        if (dimension == 2) return static_cast<LawBatch<Real, 2>*>(new LawBatchOf<Law<Real>, Real, 2>(law, density));
        return static_cast<LawBatch<Real, 3>*>(new LawBatchOf<Law<Real>, Real, 3>(law, density));
    });
}

template <template <class> class Law>
std::size_t write_law(int bytes, const double* values, void* at) {
    return with_real(bytes, [&]<class Real>(Real) {
        const Law<Real> law(values);
        static_assert(std::is_trivially_copyable_v<Law<Real>>, "a law is numbers: devices get a copy of its bytes");
        if (at) std::memcpy(at, &law, sizeof(law));
        return sizeof(law);
    });
}

}  // namespace detail

/// What an object's entry, moraine_law(), returns; name, path, text and type are the program's to set.
template <template <class> class Law>
LawInfo describe_object() {
    static_assert(detail::Complete<Law<double>>,
                  "the file has no `template <class Real> struct Law` in namespace moraine");
    LawInfo info = describe<Law>(-1);
    info.file.make_batch = detail::make_law_batch_of<Law>;
    info.file.write = detail::write_law<Law>;
    return info;
}

}  // namespace moraine
