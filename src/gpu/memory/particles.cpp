#include "gpu/memory/particles.hpp"

#include <algorithm>

#include "core/particles/particle_bytes.hpp"
#include "gpu/memory/packing.hpp"
#include "gpu/memory/refresh.hpp"

namespace moraine::gpu {

namespace {

constexpr std::size_t chunk_rows = 1 << 20;  ///< that travel at once

template <class T, class Spare>
void order(const Array<T>& column, const Array<Spare>& spare, const std::uint32_t* slot, std::size_t n,
           cudaStream_t stream) {
    static_assert(sizeof(T) <= sizeof(Spare));
    permute(static_cast<std::uint32_t>(n), slot, column.data(), spare.data(), sizeof(T), stream);
}

}  // namespace

/// Calls f(number) for the reals in no row that the scene has.
template <class Real, int Dim>
template <class F>
void DeviceParticles<Real, Dim>::each_present(const F& f) const {
    each_own_column<Dim>([&](const auto& variable, int k) {
        if (variable.present(needs_)) f(k);
    });
}

template <class Real, int Dim>
Columns<Real, Dim> DeviceParticles<Real, Dim>::view() const {
    Columns<Real, Dim> v{};
    each_row_of<Dim>([&](RowGroup group, int k, int) {
        if (has_rows<Dim>(needs_, group)) v.row(group, k) = rows_[static_cast<int>(group)][k].data();
    });
    each_present([&](int k) { v.own[k] = own_[k].data(); });
    v.id = id_.data();
    v.body = body_.data();
    return v;
}

/// Calls f(column of rows) for every one that the scene has.
template <class Real, int Dim>
template <class F>
void DeviceParticles<Real, Dim>::each_row(const F& f) {
    each_row_of<Dim>([&](RowGroup group, int k, int) {
        if (has_rows<Dim>(needs_, group)) f(rows_[static_cast<int>(group)][k]);
    });
}

/// And f(column) for its reals that are in no row.
template <class Real, int Dim>
template <class F>
void DeviceParticles<Real, Dim>::each_scalar(const F& f) {
    each_present([&](int k) { f(own_[k]); });
}

/// And f(column) for the words of sleep, where the scene has them.
template <class Real, int Dim>
template <class F>
void DeviceParticles<Real, Dim>::each_word(const F& f) {
    if (needs_.sleep) f(rest_place_), f(rest_stress_);
}

/// A column of the host in terms of rows, or of a word of sleep.
template <class Real, int Dim>
std::vector<RowPart> DeviceParticles<Real, Dim>::parts(std::string_view name) const {
    const auto word = [](const Array<std::uint64_t>& column) {
        return std::vector<RowPart>{{column.data(), sizeof(std::uint64_t), 1, 0, 1, 1, 0}};
    };
    if (name == "rest_place") return word(rest_place_);
    if (name == "rest_stress") return word(rest_stress_);
    return parts_of(view(), name);
}

/// Lanes without a meaning are copied too: all begin as zeros.
template <class Real, int Dim>
void DeviceParticles<Real, Dim>::resize(std::size_t n) {
    each_row([&](Array<Row<Real>>& row) {
        row.resize(n);
        check(cudaMemset(row.data(), 0, n * sizeof(Row<Real>)), "Clearing particles");
    });
    each_scalar([&](Array<Real>& column) { column.resize(n); });
    each_word([&](Array<std::uint64_t>& column) { column.resize(n); });
    id_.resize(n), body_.resize(n + n % 2);  // P2G reads bodies in pairs
    spare_.resize(n);
}

template <class Real, int Dim>
void DeviceParticles<Real, Dim>::clear(std::size_t n) {
    resize(n);
    each_scalar(
        [&](Array<Real>& column) { check(cudaMemset(column.data(), 0, n * sizeof(Real)), "Clearing particles"); });
    each_word([&](Array<std::uint64_t>& column) {
        check(cudaMemset(column.data(), 0, n * sizeof(std::uint64_t)), "Clearing particles");
    });
    check(cudaDeviceSynchronize(), "Clearing particles");
}

/// Calls f(first row, rows, their places in the chunk) for parts that fit into the staging memory.
template <class Real, int Dim>
template <class F>
void DeviceParticles<Real, Dim>::each_chunk(const ColumnBytes& column, std::size_t n, const F& f) {
    const std::size_t most = std::min(n, chunk_rows);
    staging_.resize(most * column.row_bytes);
    for (std::size_t first = 0; first < n; first += most) f(first, std::min(most, n - first));
}

template <class Real, int Dim>
void DeviceParticles<Real, Dim>::grow(std::size_t n, std::size_t most) {
    const auto longer = [&]<class T>(Array<T>& column, std::size_t capacity) {
        Array<T> fresh;
        fresh.resize(capacity);
        check(cudaMemcpy(fresh.data(), column.data(), n * sizeof(T), cudaMemcpyDeviceToDevice),
              "Growing the storage of particles");
        column.swap(fresh);
    };
    spare_.release();
    each_row([&](Array<Row<Real>>& row) { longer(row, most); });
    each_scalar([&](Array<Real>& column) { longer(column, most); });
    each_word([&](Array<std::uint64_t>& column) { longer(column, most); });
    longer(id_, most), longer(body_, most + most % 2);
    spare_.resize(most);
}

template <class Real, int Dim>
void DeviceParticles<Real, Dim>::upload(const std::vector<ColumnBytes>& columns,
                                        const std::vector<std::uint32_t>& slots, std::size_t most) {
    resize(most);
    place_.resize(slots.size());
    count_up(static_cast<std::uint32_t>(slots.size()), place_.data(), nullptr);
    std::vector<std::byte> rows;
    for (const ColumnBytes& c : columns)
        each_chunk(c, slots.size(), [&](std::size_t first, std::size_t n) {
            rows.resize(n * c.row_bytes);
            pack_column(c, std::span(slots).subspan(first, n), rows.data());
            check(cudaMemcpy(staging_.data(), rows.data(), rows.size(), cudaMemcpyHostToDevice),
                  "Copying to the device");
            for (const RowPart& part : parts(c.name))
                unpack_rows(static_cast<std::uint32_t>(n), place_.data() + first, part, staging_.data(), nullptr);
        });
    check(cudaDeviceSynchronize(), "Taking particles in");
    place_.release();
}

template <class Real, int Dim>
void DeviceParticles<Real, Dim>::download(const std::vector<ColumnBytes>& columns, const std::uint32_t* slot,
                                          std::size_t n) {
    for (const ColumnBytes& c : columns)
        each_chunk(c, n, [&](std::size_t first, std::size_t rows) {
            for (const RowPart& part : parts(c.name))
                pack_rows(static_cast<std::uint32_t>(rows), slot + first, part, staging_.data(), nullptr);
            check(cudaMemcpy(c.data + first * c.row_bytes, staging_.data(), rows * c.row_bytes, cudaMemcpyDeviceToHost),
                  "Copying from the device");
        });
}

/// Rows take the spare one's place by turns. Who goes through them forwards and then backwards finds each where it was:
/// launches that are kept (gpu/lead_graph.hpp) need two places for each. Narrower columns go through it and back: some
/// bytes that are copied once more, every so many steps, instead of spare columns of their own.
template <class Real, int Dim>
void DeviceParticles<Real, Dim>::refresh(const std::uint32_t* slot, std::size_t n, cudaStream_t stream) {
    std::vector<Array<Row<Real>>*> rows;
    each_row([&](Array<Row<Real>>& column) { rows.push_back(&column); });
    if (backwards_) std::reverse(rows.begin(), rows.end());
    for (Array<Row<Real>>* column : rows) {
        order(*column, spare_, slot, n, stream);
        column->swap(spare_);
    }
    backwards_ = !backwards_;
    const auto through = [&]<class T>(Array<T>& column) {
        order(column, spare_, slot, n, stream);
        check(cudaMemcpyAsync(column.data(), spare_.data(), n * sizeof(T), cudaMemcpyDeviceToDevice, stream),
              "Putting particles in order");
    };
    each_scalar(through);
    each_word(through);
    through(id_), through(body_);
}

template <class Real, int Dim>
Columns<Real, Dim> DeviceParticles<Real, Dim>::view_after_refresh() const {
    Columns<Real, Dim> v = view();
    std::vector<Row<Real>**> rows;
    each_row_of<Dim>([&](RowGroup group, int k, int) {
        if (has_rows<Dim>(needs_, group)) rows.push_back(&v.row(group, k));
    });
    if (backwards_) std::reverse(rows.begin(), rows.end());
    Row<Real>* spare = spare_.data();
    for (Row<Real>** column : rows) std::swap(*column, spare);
    return v;
}

template class DeviceParticles<float, 2>;
template class DeviceParticles<float, 3>;
template class DeviceParticles<double, 2>;
template class DeviceParticles<double, 3>;

}  // namespace moraine::gpu
