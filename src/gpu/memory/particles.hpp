#pragma once
// The particles of a rank on the device, as columns of rows (gpu/memory/particle_rows.hpp), and their way to the host's
// columns and back: only for output, checkpoints and when blocks move between ranks.

#include <vector>

#include "core/particles/particles.hpp"
#include "gpu/memory/array.hpp"
#include "gpu/memory/packing.hpp"
#include "gpu/memory/particle_rows.hpp"
#include "gpu/memory/rest_words.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
class DeviceParticles {
  public:
    explicit DeviceParticles(const ColumnNeeds& needs) : needs_(needs) {}

    std::size_t capacity() const { return id_.size(); }  ///< slots
    Columns<Real, Dim> view() const;
    RestWords rest() const { return {rest_place_.data(), rest_stress_.data()}; }

    /// Capacity for n particles, all of them zeros. Synchronous.
    void clear(std::size_t n);
    /// Takes the host's particles: slot k is what slots[k] is there; capacity for `most`. Synchronous.
    void upload(const std::vector<ColumnBytes>& columns, const std::vector<std::uint32_t>& slots, std::size_t most);
    /// Capacity for `most`; the first n slots keep what they hold. Synchronous.
    void grow(std::size_t n, std::size_t most);
    /// Row k of the host's columns becomes the particle in slot[k] (on the device), k < n. Synchronous.
    void download(const std::vector<ColumnBytes>& columns, const std::uint32_t* slot, std::size_t n);
    /// Slot k takes what was in slot[k] (on the device). Asynchronous.
    void refresh(const std::uint32_t* slot, std::size_t n, cudaStream_t stream);
    /// Where columns will be after the next refresh.
    Columns<Real, Dim> view_after_refresh() const;

  private:
    void resize(std::size_t n);
    template <class F>
    void each_row(const F& f);
    template <class F>
    void each_present(const F& f) const;
    template <class F>
    void each_scalar(const F& f);
    template <class F>
    void each_word(const F& f);
    std::vector<RowPart> parts(std::string_view name) const;
    template <class F>
    void each_chunk(const ColumnBytes& column, std::size_t n, const F& f);

    ColumnNeeds needs_;
    Array<Row<Real>> rows_[row_groups][most_group_rows], spare_;  ///< by group and row of it
    Array<Real> own_[own_columns<Dim>()];                         ///< reals that are in no row
    Array<std::uint64_t> id_;
    Array<std::uint16_t> body_;
    Array<std::uint64_t> rest_place_, rest_stress_;  ///< empty: nobody sleeps in the scene
    bool backwards_ = false;                         ///< the next refresh
    Array<std::uint32_t> place_;                     ///< 0, 1, 2, ...: slots of a chunk
    Array<std::byte> staging_;
};

}  // namespace moraine::gpu
