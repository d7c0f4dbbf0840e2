#pragma once
// Particles as columns: one array per variable of the table (core/particles/particle_state.hpp), and only those that
// the scene's transfer, shape and materials name. A particle lives in a slot until the memory is refreshed; lists of
// slots move every step, particles do not (core/grid/binning.hpp).

#include <cstddef>
#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include "core/particles/particle_state.hpp"

namespace moraine {

/// A column as bytes, for packing, files and hashes.
struct ColumnBytes {
    std::string name;
    std::string unit;
    std::size_t row_bytes;
    std::size_t scalar_bytes;
    std::byte* data;
};

template <class Space, class Real, int Dim>
class Particles {
  public:
    explicit Particles(const ColumnNeeds& needs) : needs_(needs) {}

    std::size_t size() const { return std::get<0>(columns_).size(); }  ///< slots: every particle has an id

    /// Makes space for n slots in every column. New slots hold anything.
    void resize(std::size_t n);

    void reserve(std::size_t n);

    /// Here, so that who wants one column of one particle pays for no other.
    ParticleView<Real, Dim> view() {
        ParticleView<Real, Dim> v{};
        each_column([&](const auto& variable, auto& column) { variable.pointer(v) = column.data(); });
        return v;
    }

    /// The state: every column but those that a step makes anew, in the order of the table.
    std::vector<ColumnBytes> columns();

    /// Bytes of one particle in all columns.
    std::size_t row_bytes();

    /// Slot k takes what was in slot order[k]; one column at a time, so that the spare memory is one column.
    void permute(const std::uint32_t* order, std::size_t n);

  private:
    using Table = decltype(particle_state<Real, Dim>());
    template <std::size_t K>
    using Array = typename Space::template Array<typename std::tuple_element_t<K, Table>::Type>;
    template <std::size_t... K>
    static std::tuple<Array<K>...> arrays(std::index_sequence<K...>);
    using Columns = decltype(arrays(std::make_index_sequence<std::tuple_size_v<Table>>{}));

    /// Calls f(variable, its column) for those that the scene needs.
    template <class F>
    void each_column(const F& f) {
        constexpr Table table = particle_state<Real, Dim>();
        [&]<std::size_t... K>(std::index_sequence<K...>) {
            (
                [&] {
                    if (std::get<K>(table).present(needs_)) f(std::get<K>(table), std::get<K>(columns_));
                }(),
                ...);
        }
        (std::make_index_sequence<std::tuple_size_v<Table>>{});
    }

    ColumnNeeds needs_;
    Columns columns_;
};

}  // namespace moraine
