#pragma once
// One output of particles.vtkhdf: position, labels and the fields that the scene names, in list order.
//
// Of output.every = n particles one is written, by a hash of its id: the same ones at all times, whatever the ranks,
// so that they can be followed; and no lattice of the seeding is seen in them. (Every n-th along the curve would be
// others at each output, every n-th id would take whole rows of a lattice.) Columns are made while they are written.

#include <array>
#include <cstring>

#include "core/data/hash.hpp"
#include "core/material/laws.hpp"
#include "core/particles/particle_bytes.hpp"
#include "io/vtkhdf.hpp"
#include "records/checkpoint_state.hpp"
#include "records/field_scalar.hpp"
#include "records/pore_fields.hpp"
#include "simulation/diagnostics.hpp"

namespace moraine {

/// Whether the particle is one of those that outputs of `every` show.
inline bool is_shown(std::uint64_t id, std::uint64_t every) {
    return every <= 1 || mix(id) % every == 0;
}

template <class Real, int Dim>
class OutputFrame {
  public:
    /// Not collective; its members want the binned state.
    explicit OutputFrame(Simulation<Real, Dim>& sim)
        : sim_(sim), every_(static_cast<std::uint64_t>(sim.scene().output.every)), single_(sim.scene().output.single) {
        position_ = reals("position", "m", Dim, {"position"},
                          [this](const Piece& piece, int b, std::uint32_t s) { return place_of(sim_, piece, b, s); });
        if (has_label("id")) stored("id", "id");
        for (const std::string& field : sim.scene().output.fields) add(field);
    }
    OutputFrame(const OutputFrame&) = delete;
    OutputFrame& operator=(const OutputFrame&) = delete;

    const Column& position() const { return position_; }
    const std::vector<Column>& fields() const { return fields_; }
    SeriesLabels labels() const { return {has_label("rank"), has_label("block_key")}; }

    /// Collective.
    void append_to(ParticleSeries& series) const {
        series.append(sim_.clock().time, shown_rows(), position_, fields_, labels());
    }

  private:
    using Piece = SharePiece<Real, Dim>;
    using View = ParticleView<Real, Dim>;
    using Slots = std::span<const std::uint32_t>;

    bool has_label(const std::string& name) const {
        const std::vector<std::string>& labels = sim_.scene().output.labels;
        return std::find(labels.begin(), labels.end(), name) != labels.end();
    }

    /// Those of a block's particles that are shown; `chosen` has room for them.
    Slots shown(const Piece& piece, int block, std::vector<std::uint32_t>& chosen) const {
        const Slots all = piece.slots(block);
        if (every_ <= 1) return all;
        chosen.clear();
        for (std::uint32_t s : all)
            if (is_shown(piece.p.id[s], every_)) chosen.push_back(s);
        return chosen;
    }

    /// Calls f(piece, block, slots, row) for the blocks of this rank's share, on all threads; `row` is the first of the
    /// block's in a column; `needs`: what f reads.
    template <class F>
    void each_block(std::vector<std::string> needs, const F& f) const {
        if (every_ > 1) needs.emplace_back("id");
        std::size_t done = 0;
        sim_.each_piece(needs, [&](const Piece& piece) {
            std::vector<std::size_t> first(static_cast<std::size_t>(piece.end - piece.begin) + 1, 0);
            const auto at = [&](int b) -> std::size_t& { return first[static_cast<std::size_t>(b - piece.begin)]; };
#pragma omp parallel
            {
                std::vector<std::uint32_t> chosen;
#pragma omp for schedule(static)
                for (int b = piece.begin; b < piece.end; ++b) at(b + 1) = shown(piece, b, chosen).size();
#pragma omp single
                {
                    first[0] = done;
                    for (std::size_t k = 1; k < first.size(); ++k) first[k] += first[k - 1];
                }
#pragma omp for schedule(dynamic, 64)
                for (int b = piece.begin; b < piece.end; ++b) f(piece, b, shown(piece, b, chosen), at(b));
            }
            done = first.back();
        });
    }

    /// My blocks and how many of their particles are shown.
    std::vector<BlockRow> shown_rows() const {
        std::vector<BlockRow> rows = block_rows(sim_);
        if (every_ <= 1) return rows;
        for (BlockRow& row : rows) row.count = 0;
        each_block({"id"}, [&](const Piece& piece, int b, Slots slots, std::size_t) {
            const Key key = piece.tables.own[static_cast<std::size_t>(b)];
            const auto row =
                std::lower_bound(rows.begin(), rows.end(), key, [](const BlockRow& r, Key k) { return r.key < k; });
            if (row != rows.end() && row->key == key) row->count = static_cast<std::int64_t>(slots.size());
        });
        return rows;
    }

    void add(const std::string& field) {
        if (field == "pressure") {
            derived(field, "Pa", {"stress"},
                    [](const View& p, std::uint32_t s) { return -static_cast<double>(p.stress[s].trace()) / 3; });
        } else if (field == "density") {
            derived(field, "kg/m3", {"mass", "volume"}, [](const View& p, std::uint32_t s) {
                return static_cast<double>(p.mass[s]) / static_cast<double>(p.volume[s]);
            });
        } else if (field == "pore_pressure" || field == "porosity") {
            const PoreFields<Real> pores(sim_.scene());
            fields_.push_back(reals(field, field == "porosity" ? "" : "Pa", 1, pores.needs(),
                                    [this, pores, field](const Piece& piece, int b, std::uint32_t s) {
                                        const auto x = place_of(sim_, piece, b, s);
                                        return std::array{field == "porosity" ? pores.porosity(piece.p, s)
                                                                              : pores.pressure(piece.p, s, x)};
                                    }));
        } else {
            const FieldScalar scalar(sim_.scene(), field);
            if (scalar.column < 0) return stored(field, field);
            if (scalar.is_one) return stored(field, "history_" + std::to_string(scalar.column));
            derived(field, "", scalar.needs(), [scalar](const View& p, std::uint32_t s) { return scalar.value(p, s); });
        }
    }

    /// f(piece, block, slot) is an array of doubles; written as single where the scene says so.
    template <class F>
    Column reals(const std::string& name, const std::string& unit, int components,
                 const std::vector<std::string>& needs, const F& f) const {
        Column column = {name, unit, single_ ? Column::Type::f32 : Column::Type::f64, components};
        column.make = [this, needs, f, row_bytes = static_cast<std::size_t>(column.row_bytes())](std::byte* rows) {
            each_block(needs, [&](const Piece& piece, int b, Slots slots, std::size_t row) {
                std::byte* to = rows + row * row_bytes;
                for (std::uint32_t s : slots) {
                    for (const double value : f(piece, b, s)) put(value, to);
                }
            });
        };
        return column;
    }

    void put(double value, std::byte*& to) const {
        const float less = static_cast<float>(value);
        const std::size_t bytes = single_ ? sizeof less : sizeof value;
        std::memcpy(to, single_ ? static_cast<const void*>(&less) : &value, bytes);
        to += bytes;
    }

    /// f(particles, slot), of the columns that it needs.
    template <class F>
    void derived(const std::string& field, const std::string& unit, const std::vector<std::string>& needs, const F& f) {
        fields_.push_back(reals(field, unit, 1, needs,
                                [f](const Piece& piece, int, std::uint32_t s) { return std::array{f(piece.p, s)}; }));
    }

    /// A column of the particles under another name.
    void stored(const std::string& field, const std::string& name) {
        for (const ColumnBytes& c : sim_.columns()) {
            if (c.name != name) continue;
            Column column = file_column(c);
            const bool narrow = single_ && column.type == Column::Type::f64;
            if (narrow) column.type = Column::Type::f32;
            column.name = field;
            column.make = [this, name, narrow,
                           row_bytes = static_cast<std::size_t>(column.row_bytes())](std::byte* rows) {
                each_block({name}, [&](const Piece& piece, int, Slots slots, std::size_t row) {
                    const ColumnBytes& from = *std::find_if(piece.columns.begin(), piece.columns.end(),
                                                            [&](const ColumnBytes& k) { return k.name == name; });
                    std::byte* to = rows + row * row_bytes;
                    if (narrow)
                        pack_narrowed(from, slots, to);
                    else
                        pack_column(from, slots, to);
                });
            };
            fields_.push_back(std::move(column));
        }
    }

    /// Doubles as single numbers.
    void pack_narrowed(const ColumnBytes& from, Slots slots, std::byte* to) const {
        std::array<double, 16> row{};
        for (std::uint32_t s : slots) {
            std::memcpy(row.data(), from.data + s * from.row_bytes, from.row_bytes);
            for (std::size_t k = 0; k < from.row_bytes / 8; ++k) put(row[k], to);
        }
    }

    Simulation<Real, Dim>& sim_;
    std::uint64_t every_;
    bool single_;
    Column position_;
    std::vector<Column> fields_;
};

}  // namespace moraine
