#include "core/particles/particles.hpp"

#include <cstdint>
#include <type_traits>

#include "core/data/host.hpp"

namespace moraine {

template <class Space, class Real, int Dim>
void Particles<Space, Real, Dim>::resize(std::size_t n) {
    each_column([&](const auto&, auto& column) { column.resize(n); });
}

template <class Space, class Real, int Dim>
void Particles<Space, Real, Dim>::reserve(std::size_t n) {
    each_column([&](const auto&, auto& column) { column.reserve(n); });
}

template <class Space, class Real, int Dim>
std::vector<ColumnBytes> Particles<Space, Real, Dim>::columns() {
    std::vector<ColumnBytes> all;
    each_column([&](const auto& variable, auto& column) {
        if (variable.lives != Lifetime::step)
            all.push_back({variable.name, variable.unit, sizeof(*column.data()), variable.scalar_bytes,
                           reinterpret_cast<std::byte*>(column.data())});
    });
    return all;
}

template <class Space, class Real, int Dim>
std::size_t Particles<Space, Real, Dim>::row_bytes() {
    std::size_t sum = 0;
    for (const ColumnBytes& c : columns()) sum += c.row_bytes;
    return sum;
}

template <class Space, class Real, int Dim>
void Particles<Space, Real, Dim>::permute(const std::uint32_t* order, std::size_t n) {
    each_column([&](const auto&, auto& column) {
        std::remove_reference_t<decltype(column)> fresh;
        fresh.resize(n);
        auto* to = fresh.data();
        const auto* from = column.data();
        Space::launch(static_cast<std::int64_t>(n), [=](int k) { to[k] = from[order[k]]; });
        column.swap(fresh);
    });
}

template class Particles<Host, float, 2>;
template class Particles<Host, float, 3>;
template class Particles<Host, double, 2>;
template class Particles<Host, double, 3>;

}  // namespace moraine
