#include <doctest/doctest.h>

#include <random>

#include "core/data/host.hpp"
#include "core/particles/particle_bytes.hpp"

using namespace moraine;

namespace {

ColumnNeeds every_column() {
    ColumnNeeds needs;
    needs.affine = needs.left_stretch = needs.log_stretch = true;
    needs.history = max_history;
    return needs;
}

template <class Real, int Dim>
struct Filled {
    Particles<Host, Real, Dim> particles{every_column()};

    explicit Filled(std::size_t n, unsigned seed) {
        particles.resize(n);
        std::mt19937_64 random(seed);
        for (const ColumnBytes& c : particles.columns())
            for (std::size_t k = 0; k < n * c.row_bytes; ++k) c.data[k] = static_cast<std::byte>(random());
    }
};

}  // namespace

TEST_CASE("padding goes up to the next multiple of eight bytes") {
    CHECK(padded(0) == 0);
    CHECK(padded(1) == 8);
    CHECK(padded(8) == 8);
    CHECK(padded(9) == 16);
}

TEST_CASE_TEMPLATE("rows that were gathered and scattered are the same in every column", Real, float, double) {
    for (std::size_t n : {0u, 1u, 3u, 8u, 33u}) {
        Filled<Real, 3> from(50, 1), to(70, 2);
        std::vector<std::uint32_t> source, target;
        for (std::size_t k = 0; k < n; ++k) {
            source.push_back(static_cast<std::uint32_t>(k * 7 % 50));
            target.push_back(static_cast<std::uint32_t>(69 - 2 * k));
        }
        const std::vector<ColumnBytes> a = from.particles.columns();
        const std::vector<ColumnBytes> b = to.particles.columns();
        std::vector<std::byte> bytes(rows_bytes(a, n) + 1, std::byte{0xee});
        CHECK(pack_rows(a, source, bytes.data()) == bytes.data() + rows_bytes(a, n));
        CHECK(bytes.back() == std::byte{0xee});
        CHECK(unpack_rows(b, target, bytes.data()) == bytes.data() + rows_bytes(a, n));
        for (std::size_t c = 0; c < a.size(); ++c)
            for (std::size_t k = 0; k < n; ++k)
                REQUIRE(std::memcmp(b[c].data + target[k] * b[c].row_bytes, a[c].data + source[k] * a[c].row_bytes,
                                    a[c].row_bytes) == 0);
    }
}

TEST_CASE("scattering rows touches no other slot") {
    Filled<double, 2> from(10, 3), to(10, 4), same(10, 4);
    const std::vector<std::uint32_t> slots{2, 5};
    std::vector<std::byte> bytes(rows_bytes(from.particles.columns(), 2));
    pack_rows(from.particles.columns(), slots, bytes.data());
    unpack_rows(to.particles.columns(), slots, bytes.data());
    const std::vector<ColumnBytes> a = to.particles.columns();
    const std::vector<ColumnBytes> b = same.particles.columns();
    for (std::size_t c = 0; c < a.size(); ++c)
        for (std::size_t k = 0; k < 10; ++k)
            if (k != 2 && k != 5)
                CHECK(std::memcmp(a[c].data + k * a[c].row_bytes, b[c].data + k * b[c].row_bytes, a[c].row_bytes) == 0);
}
