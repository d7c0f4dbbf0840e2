#pragma once
// One output of cells.vtkhdf: a row for each cell that holds particles, at its centre, with means over them.
//
//   mass, volume: sums;  velocity = sum m v / sum m;  density = sum m / sum V;  any other q: sum V q / sum V
//   volume_fraction = sum V / (h^d s), s: the share of the cell inside the domain
//
// A cell is what particles are binned by (core/data/position.hpp): around a node for stencils of three nodes, between
// nodes for others. So a cell lies in one block, on one rank, and nothing is exchanged; values of nodes would want the
// tiles of all ranks around. Sums run over the list in doubles: the same bits on any ranks and threads.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "core/data/position.hpp"
#include "core/material/laws.hpp"
#include "io/vtkhdf.hpp"
#include "records/checkpoint_state.hpp"
#include "records/field_scalar.hpp"
#include "records/pore_fields.hpp"

namespace moraine {

template <class Real, int Dim>
class CellFrame {
  public:
    /// Not collective; its members want the binned state.
    explicit CellFrame(Simulation<Real, Dim>& sim)
        : sim_(sim), type_(sim.scene().output.single ? Column::Type::f32 : Column::Type::f64) {
        position_ = column("position", "m", Dim, 0);
        add_ratio("volume_fraction", "-");
        for (const std::string& field : sim.scene().output.fields) add(field);
    }
    CellFrame(const CellFrame&) = delete;
    CellFrame& operator=(const CellFrame&) = delete;

    const Column& position() const { return position_; }
    const std::vector<Column>& fields() const { return columns_; }
    SeriesLabels labels() const {
        const std::vector<std::string>& labels = sim_.scene().output.labels;
        const auto has = [&](const char* name) {
            return std::find(labels.begin(), labels.end(), name) != labels.end();
        };
        return {has("rank"), has("block_key")};
    }

    /// Collective.
    void append_to(ParticleSeries& series) {
        collect();
        series.append(sim_.clock().time, rows_, position_, columns_, labels());
    }

  private:
    static constexpr int cells = Dim == 2 ? 16 : 64;  ///< of a block
    using Piece = SharePiece<Real, Dim>;
    using Slots = std::span<const std::uint32_t>;

    /// The particles of a block: their slots and cells.
    struct Binned {
        const Piece& piece;
        Slots slots;
        std::vector<int> cell;
    };

    /// What a mean is of. `read` adds weight times value of each particle to its cell's `components` numbers.
    struct Field {
        enum class Weight { none, mass, volume, ratio };
        std::string name;  ///< of a ratio its own, else of the column that it reads
        Weight weight;
        int components, at;  ///< in a row of numbers
        std::function<void(const Binned&, double* sums)> read;
    };

    Column column(const std::string& name, const std::string& unit, int components, int at) {
        Column c = {name, unit, type_, components};
        c.make = [this, components, at](std::byte* to) {
            for (std::size_t row = 0; row < numbers_.size(); row += width())
                for (int k = 0; k < components; ++k) put(numbers_[row + static_cast<std::size_t>(at + k)], to);
        };
        return c;
    }

    void put(double value, std::byte*& to) const {
        const float less = static_cast<float>(value);
        const bool single = type_ == Column::Type::f32;
        std::memcpy(to, single ? static_cast<const void*>(&less) : &value, single ? sizeof less : sizeof value);
        to += single ? sizeof less : sizeof value;
    }

    std::size_t width() const { return static_cast<std::size_t>(fields_.back().at + fields_.back().components); }

    void add(const std::string& field) {
        using Weight = typename Field::Weight;
        if (field == "density") return add_ratio(field, "kg/m3");
        if (field == "pressure")
            return add_mean({"stress", Weight::volume, 1, 0,
                             [](const Binned& b, double* sums) {
                                 for (std::size_t k = 0; k < b.slots.size(); ++k) {
                                     const std::uint32_t s = b.slots[k];
                                     sums[b.cell[k]] -= static_cast<double>(b.piece.p.volume[s]) *
                                                        static_cast<double>(b.piece.p.stress[s].trace()) / 3;
                                 }
                             }},
                            field, "Pa");
        if (field == "porosity") {
            const PoreFields<Real> pores(sim_.scene());
            for (const std::string& name : pores.needs()) needs_.push_back(name);
            return add_mean({"ln_J", Weight::volume, 1, 0,
                             [pores](const Binned& b, double* sums) {
                                 for (std::size_t k = 0; k < b.slots.size(); ++k)
                                     sums[b.cell[k]] += static_cast<double>(b.piece.p.volume[b.slots[k]]) *
                                                        pores.porosity(b.piece.p, b.slots[k]);
                             }},
                            field, "-");
        }
        const FieldScalar scalar(sim_.scene(), field);
        if (!scalar.is_one) {
            const auto sum = [scalar](const Binned& b, double* sums) {
                for (std::size_t k = 0; k < b.slots.size(); ++k)
                    sums[b.cell[k]] +=
                        static_cast<double>(b.piece.p.volume[b.slots[k]]) * scalar.value(b.piece.p, b.slots[k]);
            };
            for (const std::string& name : scalar.needs()) needs_.push_back(name);
            return add_mean({"body", Weight::volume, 1, 0, sum}, field, "-");
        }
        const std::string name = scalar.column < 0 ? field : "history_" + std::to_string(scalar.column);
        const Weight weight = field == "velocity"                    ? Weight::mass
                              : field == "mass" || field == "volume" ? Weight::none
                                                                     : Weight::volume;
        for (const ColumnBytes& c : sim_.columns())
            if (c.name == name)
                add_mean({name, weight, static_cast<int>(c.row_bytes / sizeof(Real)), 0, stored(name, weight)}, field,
                         c.unit.empty() ? "-" : c.unit);
    }

    /// Sums over a column of the particles.
    static std::function<void(const Binned&, double*)> stored(const std::string& name, typename Field::Weight weight) {
        return [name, weight](const Binned& b, double* sums) {
            const auto& from = *std::find_if(b.piece.columns.begin(), b.piece.columns.end(),
                                             [&](const ColumnBytes& c) { return c.name == name; });
            const std::size_t components = from.row_bytes / sizeof(Real);
            for (std::size_t k = 0; k < b.slots.size(); ++k) {
                const std::uint32_t s = b.slots[k];
                const double w = weight == Field::Weight::none   ? 1
                                 : weight == Field::Weight::mass ? static_cast<double>(b.piece.p.mass[s])
                                                                 : static_cast<double>(b.piece.p.volume[s]);
                for (std::size_t i = 0; i < components; ++i) {
                    Real value;
                    std::memcpy(&value, from.data + s * from.row_bytes + i * sizeof(Real), sizeof value);
                    sums[static_cast<std::size_t>(b.cell[k]) * components + i] += w * static_cast<double>(value);
                }
            }
        };
    }

    void add_mean(Field field, const std::string& name, const std::string& unit) {
        field.at = fields_.empty() ? Dim : static_cast<int>(width());
        columns_.push_back(column(name, unit, field.components, field.at));
        fields_.push_back(std::move(field));
    }
    void add_ratio(const std::string& name, const std::string& unit) {
        add_mean({name, Field::Weight::ratio, 1, 0, nullptr}, name, unit);
    }

    static void bin(Binned& b) {
        b.cell.clear();
        for (std::uint32_t s : b.slots) {
            int c = 0;
            for (int a = 0; a < Dim; ++a) c |= cell_of<Real>(b.piece.p.position[s][a]) << (2 * a);
            b.cell.push_back(c);
        }
    }
    static std::uint64_t occupied(const Binned& b) {
        std::uint64_t mask = 0;
        for (int c : b.cell) mask |= std::uint64_t(1) << c;
        return mask;
    }

    /// The rows of this rank, and what is in them.
    void collect() {
        std::vector<std::string> needs = needs_;
        for (const Field& f : fields_)
            if (f.read && std::find(needs.begin(), needs.end(), f.name) == needs.end()) needs.push_back(f.name);
        rows_.clear();
        numbers_.clear();
        sim_.each_piece(needs, [&](const Piece& piece) { collect(piece); });
    }

    void collect(const Piece& piece) {
        std::vector<std::size_t> first(static_cast<std::size_t>(piece.end - piece.begin) + 1, 0);
        const auto at = [&](int b) -> std::size_t& { return first[static_cast<std::size_t>(b - piece.begin)]; };
#pragma omp parallel
        {
            Binned binned{piece, {}, {}};
            std::vector<double> sums;
#pragma omp for schedule(dynamic, 64)
            for (int b = piece.begin; b < piece.end; ++b) {
                binned.slots = piece.slots(b);
                bin(binned);
                at(b + 1) = static_cast<std::size_t>(std::popcount(occupied(binned)));
            }
#pragma omp single
            number(piece, first);
#pragma omp for schedule(dynamic, 64)
            for (int b = piece.begin; b < piece.end; ++b) {
                binned.slots = piece.slots(b);
                bin(binned);
                fill(binned, piece.tables.position[static_cast<std::size_t>(b)], sums, numbers_.data() + at(b));
            }
        }
    }

    /// Numbers of rows to where each block's begin.
    void number(const Piece& piece, std::vector<std::size_t>& first) {
        first[0] = numbers_.size();
        for (std::size_t k = 1; k < first.size(); ++k) {
            const std::size_t count = first[k];
            const Key key = piece.tables.own[static_cast<std::size_t>(piece.begin) + k - 1];
            if (count > 0) rows_.push_back({key, static_cast<std::int64_t>(count)});
            first[k] = first[k - 1] + count * width();
        }
        numbers_.resize(first.back());
    }

    /// The rows of a block's cells, in their order.
    void fill(const Binned& b, const Vec<std::int32_t, Dim>& block, std::vector<double>& sums, double* to) const {
        std::vector<double> mass(cells, 0), volume(cells, 0);
        for (std::size_t k = 0; k < b.slots.size(); ++k) {
            mass[static_cast<std::size_t>(b.cell[k])] += static_cast<double>(b.piece.p.mass[b.slots[k]]);
            volume[static_cast<std::size_t>(b.cell[k])] += static_cast<double>(b.piece.p.volume[b.slots[k]]);
        }
        const std::uint64_t mask = occupied(b);
        const auto each_row = [&](const auto& f) {
            double* row = to;
            for (int c = 0; c < cells; ++c)
                if (mask >> c & 1) f(c, static_cast<std::size_t>(c), row), row += width();
        };
        std::vector<double> inside(cells, 1);
        each_row([&](int c, std::size_t n, double* row) { inside[n] = place(block, c, row); });
        for (const Field& f : fields_) {
            const auto width = static_cast<std::size_t>(f.components);
            sums.assign(cells * width, 0);
            if (f.read) f.read(b, sums.data());
            each_row([&](int, std::size_t n, double* row) {
                if (f.name == "volume_fraction") sums[n] = volume[n] / (cell_volume() * inside[n]);
                if (f.name == "density") sums[n] = mass[n] / volume[n];
                const double by = f.weight == Field::Weight::mass     ? mass[n]
                                  : f.weight == Field::Weight::volume ? volume[n]
                                                                      : 1;
                for (std::size_t i = 0; i < width; ++i)
                    row[static_cast<std::size_t>(f.at) + i] = sums[n * width + i] / by;
            });
        }
    }

    double cell_volume() const {
        return std::pow(sim_.scene().cell, Dim);
    }

    /// Writes a cell's centre [m]; returns its share inside the domain.
    double place(const Vec<std::int32_t, Dim>& block, int cell, double* x) const {
        const Scene& scene = sim_.scene();
        double share = 1;
        for (int a = 0; a < Dim; ++a) {
            const auto i = static_cast<std::size_t>(a);
            const double low = 4.0 * block[a] + (cell >> (2 * a) & 3) - sim_.method().stencil.offset();
            x[a] = scene.min[i] + scene.cell * (low + 0.5);
            const double end = std::round((scene.max[i] - scene.min[i]) / scene.cell);
            const double here = std::min(low + 1, end) - std::max(low, 0.0);
            if (!scene.periodic[i] && here > 0) share *= here;
        }
        return share;
    }

    Simulation<Real, Dim>& sim_;
    Column::Type type_;
    Column position_;
    std::vector<Column> columns_;
    std::vector<std::string> needs_{"position", "mass", "volume"};
    std::vector<Field> fields_;
    std::vector<BlockRow> rows_;
    std::vector<double> numbers_;  ///< by row: the place, then the fields
};

}  // namespace moraine
