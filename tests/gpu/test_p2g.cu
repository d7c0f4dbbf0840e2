#include <doctest/doctest.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "every_case.hpp"
#include "gpu/dense_box.cuh"
#include "gpu/device_sample.cuh"
#include "gpu/kernels/p2g/p2g.hpp"
#include "gpu/kernels/programs.hpp"
#include "gpu/overfull_cells.hpp"

using namespace moraine;
using moraine::test::DeviceSample;
using moraine::test::Node;
using moraine::test::NodeSums;
using moraine::test::Sample;

namespace {

template <class C, class F>
void each_method(const F& f) {
    using moraine::Shape;
    for (Shape shape : {Shape::linear, Shape::gimp, Shape::gimp_contiguous, Shape::quadratic, Shape::cubic})
        for (Transfer transfer : {Transfer::flip, Transfer::apic})
            for (bool periodic : {false, true}) {
                CAPTURE(int(shape));
                CAPTURE(int(transfer));
                CAPTURE(periodic);
                Scene scene = test::sample_scene(C::dim, shape, periodic);
                scene.transfer = transfer;
                Sample<typename C::Real, C::dim> sample(scene, C::dim == 2 ? 1200 : 3000, 11);
                test::overfill(sample);
                REQUIRE(test::fullest_cell(sample) >= 100);
                f(sample);
            }
}

/// The tiles that `grid_blocks` thread blocks write.
template <class Real, int Dim>
std::vector<Quad<Real>> tiles_of(Sample<Real, Dim>& sample, int grid_blocks) {
    const DeviceSample<Real, Dim> device(sample);
    const gpu::P2g<Real, Dim> run(gpu::device_kernel_key<Real, Dim>(sample.scene), false);
    run(device.view, device.chosen, grid_blocks, {sample.method.cell, false, false}, nullptr);
    gpu::check(cudaDeviceSynchronize(), "Particle to grid");
    return device.tiles();
}

template <class Real, int Dim>
std::map<Node<Dim>, NodeSums<Dim>> device_sums(Sample<Real, Dim>& sample) {
    const int side = tile_side(sample.method.stencil.width), tile_nodes = power<Dim>(side);
    const std::vector<Quad<Real>> tiles = tiles_of(sample, 5);
    std::map<Node<Dim>, NodeSums<Dim>> nodes;
    bool unused = true;
    for (int b = 0; b < sample.patch.own(); ++b) {
        if (sample.patch.tile_of()[b] < 0) continue;
        for (int n = 0; n < tile_nodes; ++n) {
            const Quad<Real>* from = &tiles[static_cast<std::size_t>(2 * (sample.patch.tile_of()[b] * tile_nodes + n))];
            NodeSums<Dim>& sums = nodes[node_at(sample, sample.patch.table().position[b], n, side)];
            sums.mass += double(from[0][0]);
            for (int a = 0; a < Dim; ++a) {
                sums.momentum[static_cast<std::size_t>(a)] += double(from[0][1 + a]);
                sums.force[static_cast<std::size_t>(a)] += double(from[1][a]);
            }
            for (int q = 1 + Dim; q < quad; ++q) unused = unused && from[0][q] == 0;
            for (int q = Dim; q < quad; ++q) unused = unused && from[1][q] == 0;
        }
    }
    CHECK(unused);
    return nodes;
}

/// Largest difference of two sets of sums, each field by its largest magnitude; a node that is missing counts as zero.
template <int Dim>
double difference(std::map<Node<Dim>, NodeSums<Dim>> found, std::map<Node<Dim>, NodeSums<Dim>> expected) {
    const auto fields = [](const NodeSums<Dim>& n, const auto& f) {
        f(0, n.mass);
        for (std::size_t a = 0; a < Dim; ++a) f(1, n.momentum[a]), f(2, n.force[a]);
    };
    std::array<double, 3> scale{};
    for (const auto& [node, n] : expected)
        fields(n, [&](std::size_t q, double x) { test::widen(scale[q], std::fabs(x)); });
    double worst = 0;
    for (const auto& [node, n] : found) {
        NodeSums<Dim> d = expected[node];
        d.mass -= n.mass;
        for (std::size_t a = 0; a < Dim; ++a) d.momentum[a] -= n.momentum[a], d.force[a] -= n.force[a];
        fields(d, [&](std::size_t q, double x) { test::widen(worst, std::fabs(x) / scale[q]); });
        expected.erase(node);
    }
    for (const auto& [node, n] : expected)
        fields(n, [&](std::size_t q, double x) { test::widen(worst, std::fabs(x) / scale[q]); });
    return worst;
}

/// What the last lanes of force quads add up to at each node.
template <class Real, int Dim, class Tiles>
std::map<Node<Dim>, double> sums_of_mean(Sample<Real, Dim>& sample, const Tiles& lane) {
    const int side = tile_side(sample.method.stencil.width), tile_nodes = power<Dim>(side);
    std::map<Node<Dim>, double> nodes;
    for (int b = 0; b < sample.patch.own(); ++b)
        for (int n = 0; sample.patch.tile_of()[b] >= 0 && n < tile_nodes; ++n)
            nodes[node_at(sample, sample.patch.table().position[b], n, side)] +=
                double(lane(static_cast<std::size_t>(sample.patch.tile_of()[b] * tile_nodes + n)));
    return nodes;
}

/// Largest difference of the device's mean from the host's, by the largest of those.
template <class Real, int Dim>
double difference_of_means(Sample<Real, Dim>& sample, NodeMean mean) {
    const DeviceSample<Real, Dim> device(sample);
    const gpu::P2g<Real, Dim> run(gpu::device_kernel_key<Real, Dim>(sample.scene), true);
    run(device.view, device.chosen, 5, {sample.method.cell, mean == NodeMean::volume, false}, nullptr);
    gpu::check(cudaDeviceSynchronize(), "Particle to grid");
    const std::vector<Quad<Real>> tiles = device.tiles();
    auto call = sample.call();
    call.mean = mean;
    sample.method.kernels.p2g(call, sample.method.cell);
    const Real* host = sample.patch.grid().tiles;
    const auto found = sums_of_mean(sample, [&](std::size_t n) { return tiles[2 * n + 1][quad - 1]; });
    double worst = 0, largest = 0;
    for (const auto& [node, x] :
         sums_of_mean(sample, [&](std::size_t n) { return host[n * node_reals + 2 * quad - 1]; })) {
        test::widen(worst, std::fabs(found.at(node) - x));
        test::widen(largest, std::fabs(x));
    }
    CHECK(largest > 0);
    return worst / largest;
}

template <class Real>
bool same_bits(const std::vector<Quad<Real>>& a, const std::vector<Quad<Real>>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0;
}

}  // namespace

TEST_CASE_TEMPLATE("tiles written on the device add up to the plain sums over particles and nodes", C, EVERY_CASE) {
    each_method<C>([](auto& sample) {
        CHECK(difference<C::dim>(device_sums(sample), test::reference_sums(sample)) <= C::tolerance);
    });
}

TEST_CASE_TEMPLATE("the means that fluids want are the host's sums", C, EVERY_CASE) {
    each_method<C>([](auto& sample) {
        CHECK(difference_of_means(sample, NodeMean::stress) <= C::tolerance);
        CHECK(difference_of_means(sample, NodeMean::volume) <= C::tolerance);
    });
}

TEST_CASE_TEMPLATE("tiles have the same bits whatever the number of thread blocks, and in every run", C, EVERY_CASE) {
    each_method<C>([](auto& sample) {
        const auto once = tiles_of(sample, 1);
        CHECK(same_bits(once, tiles_of(sample, 1)));
        CHECK(same_bits(once, tiles_of(sample, 7)));
        CHECK(same_bits(once, tiles_of(sample, 1000)));
    });
}

TEST_CASE_TEMPLATE("a node to which no particle gives weight has no mass, to the last bit", C, EVERY_CASE) {
    constexpr int dim = C::dim;
    for (moraine::Shape shape : {moraine::Shape::linear, moraine::Shape::gimp, moraine::Shape::gimp_contiguous}) {
        CAPTURE(int(shape));
        Scene scene = test::sample_scene(dim, shape, true);
        scene.boundary_spline = false;
        Sample<typename C::Real, dim> sample(scene, 60, 12);
        auto expected = test::reference_sums(sample);
        int empty = 0, wrong = 0;
        for (const auto& [node, n] : device_sums(sample)) {
            empty += n.mass == 0;
            wrong += (n.mass == 0) != (expected[node].mass == 0);
        }
        CHECK(empty > 0);
        CHECK(wrong == 0);
    }
}

TEST_CASE_TEMPLATE("blocks that are not chosen keep their tiles", C, EVERY_CASE) {
    using Real = typename C::Real;
    Sample<Real, C::dim> sample(test::sample_scene(C::dim, moraine::Shape::quadratic, false), 1000, 13);
    const DeviceSample<Real, C::dim> device(sample);
    const std::vector<Quad<Real>> poisoned = device.tiles();
    std::vector<std::int32_t> occupied;
    for (int b = 0; b < sample.patch.own(); ++b)
        if (sample.patch.tile_of()[b] >= 0) occupied.push_back(b);
    const std::vector<std::int32_t> some = {occupied[5], occupied[1], occupied[2]};
    gpu::Array<std::int32_t> block;
    gpu::Array<std::uint32_t> count;
    block.assign(some), count.assign({3});
    const gpu::P2g<Real, C::dim> run(gpu::device_kernel_key<Real, C::dim>(sample.scene), false);
    run(device.view, {block.data(), count.data()}, 2, {sample.method.cell, false, false}, nullptr);
    const std::vector<Quad<Real>> all = tiles_of(sample, 4), found = device.tiles();
    const auto nodes = std::size_t(2 * power<C::dim>(tile_side(3)));
    for (std::int32_t b : occupied) {
        const auto at = std::size_t(sample.patch.tile_of()[b]) * nodes;
        const auto& expected = std::find(some.begin(), some.end(), b) != some.end() ? all : poisoned;
        CHECK(std::memcmp(&found[at], &expected[at], nodes * sizeof(found[0])) == 0);
    }
}

namespace {

/// Median of seven launches after three [ms].
template <class F>
double median_ms(const F& launch) {
    cudaEvent_t from, to;
    gpu::check(cudaEventCreate(&from), "Making an event"), gpu::check(cudaEventCreate(&to), "Making an event");
    std::vector<float> ms;
    for (int i = 0; i < 10; ++i) {
        gpu::check(cudaEventRecord(from), "Recording an event");
        launch();
        gpu::check(cudaEventRecord(to), "Recording an event");
        gpu::check(cudaEventSynchronize(to), "Waiting for an event");
        float t = 0;
        gpu::check(cudaEventElapsedTime(&t, from, to), "Reading events");
        if (i >= 3) ms.push_back(t);
    }
    std::sort(ms.begin(), ms.end());
    cudaEventDestroy(from), cudaEventDestroy(to);
    return double(ms[3]);
}

template <class Real, int Dim>
void time_shapes(int bits) {
    using moraine::Shape;
    const std::pair<Shape, const char*> shapes[] = {{Shape::linear, "linear"},
                                                    {Shape::gimp, "gimp"},
                                                    {Shape::gimp_contiguous, "gimp-contiguous"},
                                                    {Shape::quadratic, "quadratic"},
                                                    {Shape::cubic, "cubic"}};
    for (const auto& [shape, name] : shapes) {
        test::DenseBox<Real, Dim> box(bits, stencil_of(shape).width);
        if (shape == Shape::gimp) box.view.p.log_stretch = nullptr;
        for (bool affine : {false, true}) {
            KernelKey key{};
            key.real = sizeof(Real) == 4 ? Precision::single_ : Precision::double_;
            key.dimension = Dim, key.shape = shape, key.affine = affine;
            const gpu::P2g<Real, Dim> run(key, false);
            const gpu::MeanScale<Real> scale{Real(0.5), false, false};
            const double ms =
                median_ms([&] { run(box.view, box.chosen, gpu::p2g_grid<Dim>(box.blocks), scale, nullptr); });
            std::printf("%d-D %s %-15s %s %.3f ms %7.2f G particles/s\n", Dim, sizeof(Real) == 4 ? "single" : "double",
                        name, affine ? "affine" : "FLIP  ", ms, box.particles / ms * 1e-6);
        }
    }
}

}  // namespace

TEST_CASE("kernels have been timed" * doctest::skip(std::getenv("MORAINE_TIMING") == nullptr)) {
    time_shapes<float, 3>(15);
    time_shapes<double, 3>(14);
    time_shapes<float, 2>(18);
    time_shapes<double, 2>(17);
}
