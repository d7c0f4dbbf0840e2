#include <doctest/doctest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <random>

#include "every_case.hpp"
#include "gpu/device_sample.cuh"
#include "gpu/memory/packing.hpp"
#include "gpu/memory/refresh.hpp"
#include "gpu/memory/refresh_clock.hpp"
#include "gpu/stopwatch.hpp"

using namespace moraine;

namespace {

std::vector<std::uint32_t> mixed_slots(std::uint32_t n, unsigned seed) {
    std::vector<std::uint32_t> slot(n);
    std::iota(slot.begin(), slot.end(), 0u);
    std::mt19937_64 random(seed);
    std::shuffle(slot.begin(), slot.end(), random);
    return slot;
}

void fill_bytes(std::byte* to, std::size_t n, std::mt19937_64& random) {
    for (std::size_t k = 0; k < n; ++k) to[k] = static_cast<std::byte>(random());
}

/// All rows that there can be, poisoned.
template <class Real, int Dim>
class Rows {
  public:
    gpu::Columns<Real, Dim> columns{};

    explicit Rows(std::size_t n) {
        for (int k = 0; k < gpu::core_rows<Dim>; ++k) columns.core[k] = make(core_[k], n);
        for (int k = 0; k < gpu::affine_rows<Dim>; ++k) columns.affine[k] = make(affine_[k], n);
        for (int k = 0; k < gpu::stretch_rows<Dim>; ++k) columns.stretch[k] = make(stretch_[k], n);
        columns.log_stretch = make(log_stretch_, n);
        for (int k = 0; k < gpu::own_columns<Dim>(); ++k) columns.own[k] = make(own_[k], n);
        columns.id = make(id_, n), columns.body = make(body_, n);
    }

    gpu::CoreRows<Real, Dim> particle(std::uint32_t s) const {
        gpu::CoreRows<Real, Dim> r;
        for (int k = 0; k < gpu::core_rows<Dim>; ++k)
            gpu::check(cudaMemcpy(&r.row[k], columns.core[k] + s, sizeof(r.row[k]), cudaMemcpyDeviceToHost), "copy");
        return r;
    }

  private:
    template <class T>
    static T* make(gpu::Array<T>& array, std::size_t n) {
        array.resize(n);
        gpu::check(cudaMemset(array.data(), 0xff, n * sizeof(T)), "Poisoning");
        return array.data();
    }

    gpu::Array<gpu::Row<Real>> core_[gpu::core_rows<Dim>], affine_[gpu::affine_rows<Dim>];
    gpu::Array<gpu::Row<Real>> stretch_[gpu::stretch_rows<Dim>], log_stretch_;
    gpu::Array<Real> own_[gpu::own_columns<Dim>()];
    gpu::Array<std::uint64_t> id_;
    gpu::Array<std::uint16_t> body_;
};

}  // namespace

TEST_CASE("a refresh brings rows of every size into list order, and the lists count up") {
    std::mt19937_64 random(1);
    for (std::uint32_t n : {1u, 31u, 1024u, 20011u})
        for (std::size_t bytes : {2u, 4u, 8u, 16u, 32u}) {
            CAPTURE(n);
            CAPTURE(bytes);
            const std::vector<std::uint32_t> slots = mixed_slots(n, n);
            std::vector<std::byte> rows(n * bytes), expected(n * bytes);
            fill_bytes(rows.data(), rows.size(), random);
            for (std::uint32_t k = 0; k < n; ++k)
                std::memcpy(expected.data() + k * bytes, rows.data() + slots[k] * bytes, bytes);
            gpu::Array<std::uint32_t> slot;
            gpu::Array<std::byte> from, to;
            slot.assign(slots), from.assign(rows), to.resize(rows.size());
            gpu::permute(n, slot.data(), from.data(), to.data(), static_cast<int>(bytes), nullptr);
            CHECK(to.host() == expected);
            gpu::count_up(n, slot.data(), nullptr);
            std::vector<std::uint32_t> counted(n);
            std::iota(counted.begin(), counted.end(), 0u);
            CHECK(slot.host() == counted);
        }
    gpu::permute(0, nullptr, nullptr, nullptr, 16, nullptr);
    gpu::count_up(0, nullptr, nullptr);
    CHECK_THROWS_AS(gpu::permute(1, nullptr, nullptr, nullptr, 12, nullptr), std::logic_error);
}

TEST_CASE_TEMPLATE("every column of the host goes into rows at given slots and comes back the same", C, EVERY_CASE) {
    using Real = typename C::Real;
    const std::uint32_t n = 3001;
    std::mt19937_64 random(2);
    Particles<Host, Real, C::dim> particles({true, true, true, max_history, false});
    particles.resize(n);
    for (const ColumnBytes& c : particles.columns()) fill_bytes(c.data, n * c.row_bytes, random);
    const Rows<Real, C::dim> rows(n);
    const std::vector<std::uint32_t> slots = mixed_slots(n, 3);
    gpu::Array<std::uint32_t> slot;
    slot.assign(slots);
    for (const ColumnBytes& c : particles.columns()) {
        CAPTURE(c.name);
        gpu::Array<std::byte> packed, back;
        packed.assign(c.data, n * c.row_bytes), back.resize(n * c.row_bytes);
        const std::vector<gpu::RowPart> parts = gpu::parts_of(rows.columns, c.name);
        REQUIRE(!parts.empty());
        CHECK(parts.size() <= 3);
        for (const gpu::RowPart& part : parts) gpu::unpack_rows(n, slot.data(), part, packed.data(), nullptr);
        for (const gpu::RowPart& part : parts) gpu::pack_rows(n, slot.data(), part, back.data(), nullptr);
        CHECK(back.host() == packed.host());
    }
    const ParticleView<Real, C::dim> p = particles.view();
    for (std::uint32_t k = 0; k < n; k += 97) {
        const auto expected = test::core_rows_of(p, k), found = rows.particle(slots[k]);
        REQUIRE(std::memcmp(&expected, &found, sizeof(found)) == 0);
    }
}

TEST_CASE("columns that a scene has not are made of no parts") {
    const gpu::Columns<float, 3> none{};
    for (const char* name : {"affine", "left_strain", "log_stretch", "history_1", "unheard-of"})
        CHECK(gpu::parts_of(none, name).empty());
}

TEST_CASE("memory is refreshed rarely where the particles stay in the cache, or as often as was asked for") {
    const auto steps_of = [](gpu::RefreshClock clock, std::size_t particles) {
        clock.fit(particles, 50 << 20);
        int steps = 0;
        for (; clock.left() > 0; ++steps) clock.step();
        clock.begin_again();
        CHECK(clock.left() == steps);
        return steps;
    };
    CHECK(steps_of(gpu::RefreshClock(0), 20 << 20) == gpu::RefreshClock::rare);
    CHECK(steps_of(gpu::RefreshClock(0), 51 << 20) == gpu::RefreshClock::usual);
    CHECK(steps_of(gpu::RefreshClock(7), 20 << 20) == 7);
    CHECK(steps_of(gpu::RefreshClock(7), 51 << 20) == 7);
}

TEST_CASE("timing of a refresh, where MORAINE_TIMING asks for it") {
    if (!std::getenv("MORAINE_TIMING")) return;
    const std::uint32_t n = 1u << 24;
    std::vector<std::uint32_t> slots(n);
    std::iota(slots.begin(), slots.end(), 0u);
    std::mt19937_64 random(5);
    for (std::uint32_t k = 0; k + 2048 < n; k += 5) std::swap(slots[k], slots[k + random() % 2048]);
    gpu::Array<std::uint32_t> slot, counted;
    gpu::Array<std::byte> from, to;
    slot.assign(slots), counted.resize(n), from.resize(n * std::size_t(32)), to.resize(n * std::size_t(32));
    for (int bytes : {2, 8, 16, 32}) {
        const double ms = test::median_ms(
            20, [] {}, [&] { gpu::permute(n, slot.data(), from.data(), to.data(), bytes, nullptr); });
        std::printf("refresh of %d bytes: %.4f ms, %.2f TB/s\n", bytes, ms, n * (2.0 * bytes + 4) / ms * 1e-9);
    }
    const double ms = test::median_ms(
        20, [] {},
        [&] {
            for (int k = 0; k < 4; ++k) gpu::permute(n, slot.data(), from.data(), to.data(), 16, nullptr);
            gpu::permute(n, slot.data(), from.data(), to.data(), 8, nullptr);
            gpu::permute(n, slot.data(), from.data(), to.data(), 2, nullptr);
            gpu::count_up(n, counted.data(), nullptr);
        });
    std::printf("refresh of a particle in single: %.2f M particles, %.4f ms\n", n * 1e-6, ms);
}
