#pragma once
// Columns of particles as bytes: what the files of a run know of a particle.
//
// A column is a name, a unit and `components` numbers per row, rows packed one after the other. The
// files need no template over precision, dimension or material, so they see columns and nothing else.
// A column does not own its rows: it is made where the rows are, and used at once.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <type_traits>

#include "core/data/morton.hpp"

namespace moraine {

struct Column {
    enum class Type { u8, u16, u32, u64, f32, f64 };

    std::string name;
    std::string unit;  ///< as printed, "Pa"; "-" where there is none
    Type type = Type::f64;
    int components = 1;
    const std::byte* data = nullptr;
    /// Where data is null: writes the rows when they are needed, so that one column is in memory at a time.
    std::function<void(std::byte* rows)> make = {};

    static constexpr int bytes_of(Type type) {
        constexpr int sizes[] = {1, 2, 4, 8, 4, 8};
        return sizes[static_cast<int>(type)];
    }
    static constexpr bool is_float(Type type) { return type == Type::f32 || type == Type::f64; }

    template <class T>
    static constexpr Type type_of() {
        static_assert(std::is_floating_point_v<T> || std::is_unsigned_v<T>);
        if constexpr (std::is_floating_point_v<T>)
            return sizeof(T) == 4 ? Type::f32 : Type::f64;
        else
            return sizeof(T) == 1 ? Type::u8 : sizeof(T) == 2 ? Type::u16 : sizeof(T) == 4 ? Type::u32 : Type::u64;
    }

    /// `rows` points to the first of `components` numbers of the first row.
    template <class T>
    static Column of(std::string name, std::string unit, const T* rows, int components = 1) {
        return {
            std::move(name), std::move(unit), type_of<T>(), components, reinterpret_cast<const std::byte*>(rows), {}};
    }

    int row_bytes() const { return components * bytes_of(type); }
};

/// Particles of one block, in list order: consecutive rows.
struct BlockRow {
    Key key = 0;
    std::int64_t count = 0;
};

/// Consecutive rows of a file.
struct RowRange {
    std::int64_t start = 0;
    std::int64_t count = 0;
};

}  // namespace moraine
