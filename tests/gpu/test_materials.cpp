#include <numeric>
#include <random>
#include <set>

#include "gpu/kernels/g2p/sort_blocks.hpp"
#include "gpu/memory/array.hpp"
#include "gpu/restart_pair.hpp"
#include "material_scenes.hpp"
#include "surface_scenes.hpp"

using namespace moraine;
using namespace moraine::test;

// Scenes of several materials, whose blocks of one material have gather and stress in one kernel: which blocks these
// are, and that the answer is the host's, and that of a scene of one material to the bit where all blocks are.

namespace {

constexpr int materials = 3;

/// Blocks with particles of five bodies.
struct MadeBlocks {
    std::vector<std::uint32_t> first{0}, slot;
    std::vector<std::uint16_t> body, material_of{0, 2, 1, 2, 0};
    std::vector<std::uint8_t> limited;
    std::vector<std::int32_t> chosen;
    std::vector<int> material;  ///< of all its particles; `materials`: of several

    explicit MadeBlocks(int blocks) {
        std::mt19937 random(7);
        const auto below = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
        std::vector<std::uint16_t> by_entry;
        for (int b = 0; b < blocks; ++b) {
            const std::uint32_t count = below(5) == 0 ? below(3) : below(700);
            const auto mine = static_cast<int>(below(materials));
            for (std::uint32_t k = 0; k < count; ++k) {
                std::uint16_t of = 0;
                do of = static_cast<std::uint16_t>(below(5));
                while (material_of[of] != mine);
                by_entry.push_back(of);
            }
            bool pure = true;
            if (count > 0 && below(3) == 0) {  // a particle alone, also the first and the last
                const std::uint32_t at = below(3) == 0 ? 0 : below(2) == 0 ? count - 1 : below(count);
                by_entry[first.back() + at] = mine == 1 ? 0 : 2;
                pure = count == 1;
            }
            limited.push_back(below(8) == 0);
            material.push_back(count > 0 && pure ? material_of[by_entry[first.back()]] : materials);
            if (count > 0) chosen.push_back(b);
            first.push_back(first.back() + count);
        }
        slot.resize(by_entry.size()), body.resize(by_entry.size());
        std::iota(slot.begin(), slot.end(), 0u);
        std::shuffle(slot.begin(), slot.end(), random);
        for (std::size_t k = 0; k < slot.size(); ++k) body[slot[k]] = by_entry[k];
    }
};

/// The same on the device, sorted as often as one likes.
class Sorter {
  public:
    explicit Sorter(const MadeBlocks& made) : made_(made) {
        first_.assign(made.first), slot_.assign(made.slot), chosen_.assign(made.chosen), body_.assign(made.body);
        material_of_.assign(made.material_of);
        counts_.assign(std::vector<std::uint32_t>(2 * lists + 1, 0));
        blocks_.resize(lists * made.limited.size());
        list_of_.resize(made.limited.size());
    }

    /// Of the first `n` chosen blocks; guess: Launch::blocks.
    void check(std::uint32_t n, int guess) {
        count_.assign({n});
        std::vector<std::int32_t> limited;
        for (std::uint32_t i = 0; i < n; ++i)
            if (made_.limited[static_cast<std::size_t>(made_.chosen[i])]) limited.push_back(made_.chosen[i]);
        limited_.assign(limited), limited_count_.assign({static_cast<std::uint32_t>(limited.size())});
        const gpu::SortedBlocks to{materials,      blocks_.data(),         made_.limited.size(),
                                   counts_.data(), counts_.data() + lists, list_of_.data(),
                                   nullptr};
        gpu::sort_blocks(
            {{chosen_.data(), count_.data()}, first_.data(), slot_.data(), body_.data(), material_of_.data()}, to,
            {guess, nullptr});
        compare(n, false);
        gpu::add_to_rest({limited_.data(), limited_count_.data()}, to, {guess, nullptr});
        compare(n, true);
    }

  private:
    static constexpr std::size_t lists = materials + 1;

    void compare(std::uint32_t n, bool with_limited) const {
        gpu::check(cudaDeviceSynchronize(), "Sorting");
        const std::vector<std::uint32_t> counts = counts_.host();
        const std::vector<std::int32_t> blocks = blocks_.host();
        for (std::size_t k = 0; k < lists; ++k) {
            CAPTURE(k);
            const auto begin = blocks.begin() + static_cast<std::ptrdiff_t>(k * made_.limited.size());
            const std::multiset<std::int32_t> found(begin, begin + counts[k]);
            CHECK(found == expected(static_cast<int>(k), n, with_limited));
            CHECK(counts[lists + k] == 0);
        }
        CHECK(counts.back() == 0);
    }

    std::multiset<std::int32_t> expected(int list, std::uint32_t n, bool with_limited) const {
        std::multiset<std::int32_t> all;
        for (std::uint32_t i = 0; i < n; ++i) {
            const std::int32_t b = made_.chosen[i];
            const auto k = static_cast<std::size_t>(b);
            const bool too = list == materials && with_limited && made_.limited[k];
            if (made_.material[k] == list || too) all.insert(b);
        }
        return all;
    }

    const MadeBlocks& made_;
    gpu::Array<std::uint32_t> first_, slot_, count_, counts_, limited_count_;
    gpu::Array<std::int32_t> chosen_, blocks_, limited_;
    gpu::Array<std::uint16_t> body_, material_of_, list_of_;
};

template <class Real, int Dim>
std::uint64_t hash_of(const Scene& scene, int steps) {
    return run<Real, Dim>(scene, steps, true).hash;
}

std::uint64_t hash_of(const Scene& scene, int steps) {
    const bool single = scene.precision == Precision::single_;
    if (scene.dimensions == 2) return single ? hash_of<float, 2>(scene, steps) : hash_of<double, 2>(scene, steps);
    return single ? hash_of<float, 3>(scene, steps) : hash_of<double, 3>(scene, steps);
}

}  // namespace

TEST_CASE("blocks are sorted by material, and those of several and with light nodes are listed apart, however often") {
    const MadeBlocks made(3000);
    Sorter sorter(made);
    const auto all = static_cast<std::uint32_t>(made.chosen.size());
    for (std::uint32_t n : {all, 0u, 1u, 9u, all / 2, all})
        for (int guess : {0, 1, 100, 20000}) {
            CAPTURE(n);
            CAPTURE(guess);
            sorter.check(n, guess);
        }
}

TEST_CASE("where no block has two materials the answer is that of a scene of one, to the bit") {
    for (int dimensions : {2, 3})
        for (Precision precision : {Precision::single_, Precision::double_})
            for (Transfer transfer : {Transfer::flip, Transfer::apic, Transfer::tpic, Transfer::pic})
                for (Shape shape : {Shape::quadratic, Shape::linear})
                    for (Volumetric volumetric : {Volumetric::particle, Volumetric::cell}) {
                        if (shape == Shape::linear && is_affine(transfer)) continue;
                        std::uint64_t hash[2];
                        for (bool apart : {false, true}) {
                            Scene scene = test::twins(dimensions, apart);
                            scene.precision = precision;
                            scene.transfer = transfer;
                            scene.shape = shape;
                            scene.cfl = 0.2;
                            for (MaterialSpec& m : scene.materials) m.volumetric = volumetric;
                            hash[apart] = hash_of(scene, shape == Shape::linear ? 20 : 40);
                        }
                        CAPTURE(dimensions);
                        CAPTURE(int(precision));
                        CAPTURE(int(transfer));
                        CAPTURE(int(shape));
                        CAPTURE(int(volumetric));
                        CHECK(hash[0] == hash[1]);
                    }
}

TEST_CASE("layers, films, droplets and particles alone of two and three materials give the host's answer") {
    for (int dimensions : {2, 3})
        for (int of : {2, 3})
            for (Transfer transfer : {Transfer::flip, Transfer::apic, Transfer::tpic})
                for (bool limits : {true, false}) {
                    Scene scene = test::soils(dimensions, of);
                    scene.transfer = transfer;
                    scene.limits_light_nodes = limits;
                    CAPTURE(dimensions);
                    CAPTURE(of);
                    CAPTURE(int(transfer));
                    CAPTURE(limits);
                    compare(scene, dimensions == 2 ? 150 : 60, 1e-10);
                    if (!limits || of == 2) continue;
                    scene = test::three_sprays(dimensions);
                    scene.transfer = transfer;
                    compare(scene, 60, 1e-10);
                }
}

TEST_CASE("so they do with means of cells of one of them, with hats, and in single precision") {
    for (int averaged : {0, 1, 2}) {
        Scene scene = test::soils(2, 3);
        scene.materials[static_cast<std::size_t>(averaged)].volumetric = Volumetric::cell;
        compare(scene, 100, 1e-10);
        scene.transfer = Transfer::apic;
        compare(scene, 100, 1e-10);
    }
    Scene hats = test::soils(3, 3);
    hats.shape = Shape::linear;
    hats.cfl = 0.2;
    compare(hats, 25, 1e-10);
    Scene single = test::soils(2, 3);
    single.precision = Precision::single_;
    compare(single, 30, 1e-4);
}

TEST_CASE("strengths over depth give the host's answer, also on lattices, which begin on the host") {
    for (int dimensions : {2, 3})
        for (Seeding seeding : {Seeding::jittered, Seeding::lattice}) {
            Scene scene = test::soils_over_depth(dimensions, 1);
            for (BodySpec& body : scene.bodies) body.seeding = seeding;
            CAPTURE(dimensions);
            CAPTURE(int(seeding));
            compare(scene, dimensions == 2 ? 60 : 30, 1e-9);
        }
}

TEST_CASE("stiffness, density, friction and strengths over depth give the host's answer") {
    for (int dimensions : {2, 3})
        for (Transfer transfer : {Transfer::flip, Transfer::apic}) {
            Scene scene = test::soils_of_own(dimensions);
            scene.transfer = transfer;
            CAPTURE(dimensions);
            CAPTURE(int(transfer));
            compare(scene, dimensions == 2 ? 60 : 30, 1e-9);
        }
    Scene alone = test::soils_of_own(2);
    alone.materials.resize(1);
    for (BodySpec& body : alone.bodies) body.material = 0;
    compare(alone, 60, 1e-9);
    Scene single = test::soils_of_own(2);
    single.precision = Precision::single_;
    compare(single, 30, 1e-4);
}

TEST_CASE("interfaces that follow the soil give the host's answer, on nodes and where they are") {
    for (int dimensions : {2, 3})
        for (const Scene& scene : {test::clays_on_slope(dimensions), on_surface(test::clays_on_slope(dimensions))}) {
            CAPTURE(dimensions);
            CAPTURE(int(scene.bed));
            compare(scene, dimensions == 2 ? 80 : 40, 1e-8);
        }
}

TEST_CASE("a restart of a scene of three materials goes on with the same bits") {
    Scene scene = test::soils(2, 3);
    scene.transfer = Transfer::apic;
    test::compare_restart<2>(scene, 43, 50);
}
