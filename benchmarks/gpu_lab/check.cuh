#pragma once
// Every variant against the reference; two runs to the bit; blocks in reverse order to the bit.

#include "reference.cuh"
#include "stepper.cuh"

namespace lab {

template <class Real>
std::vector<ReferenceParticle> particles_of(const Stepper<Real>& s) {
    const auto place = s.place_.host();
    const auto motion = s.motion_.host(), normal = s.normal_.host(), shear = s.shear_.host();
    const auto id = s.id_.host();
    std::vector<ReferenceParticle> all(s.count);
    // blocks of the particles, from the lists
    std::vector<std::uint32_t> first(std::size_t(s.v.blocks) + 1), slot(s.count);
    check(cudaMemcpy(first.data(), s.v.first, first.size() * 4, cudaMemcpyDeviceToHost), "copy out");
    check(cudaMemcpy(slot.data(), s.v.slot, slot.size() * 4, cudaMemcpyDeviceToHost), "copy out");
    for (int b = 0; b < s.v.blocks; ++b)
        for (std::uint32_t k = first[std::size_t(b)]; k < first[std::size_t(b) + 1]; ++k) {
            const std::uint32_t i = slot[k];
            ReferenceParticle& p = all[id[i]];
            for (int a = 0; a < 3; ++a) {
                p.local[a] = local_of<Real>(s.topology.position[std::size_t(b)][a], place[i].u[a]);
                p.v[a] = double(motion[i].e[a]);
                p.stress[a] = double(normal[i].e[a]), p.stress[3 + a] = double(shear[i].e[a]);
            }
            p.mass = double(place[i].mass), p.volume = double(motion[i].w);
            p.ln_J = double(normal[i].w), p.xi = double(shear[i].w);
        }
    return all;
}

/// Largest difference of each field over its largest magnitude.
inline double difference(const std::vector<ReferenceParticle>& a, const std::vector<ReferenceParticle>& b,
                         const SceneSpec& s, bool print) {
    const char* names[] = {"place", "velocity", "stress", "volume", "ln J", "xi"};
    double worst[6] = {}, scale[6] = {};
    const auto see = [&](int f, double x, double y) {
        worst[f] = std::isfinite(x) ? std::max(worst[f], std::abs(x - y)) : INFINITY;
        scale[f] = std::max(scale[f], std::abs(y));
    };
    for (std::size_t i = 0; i < a.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
            double d = a[i].local[c] - b[i].local[c];
            if (c < 2) d -= s.cells[c] * std::round(d / s.cells[c]);
            see(0, b[i].local[c] + d, b[i].local[c]);
            see(1, a[i].v[c], b[i].v[c]);
        }
        for (int c = 0; c < 6; ++c) see(2, a[i].stress[c], b[i].stress[c]);
        see(3, a[i].volume, b[i].volume), see(4, a[i].ln_J, b[i].ln_J), see(5, a[i].xi, b[i].xi);
    }
    double most = 0;
    for (int f = 0; f < 6; ++f) {
        const double r = worst[f] / (scale[f] > 0 ? scale[f] : 1);
        if (print) std::printf("    %-9s %.2e of %.3g\n", names[f], r, scale[f]);
        most = std::max(most, r);
    }
    return most;
}

/// Runs `steps` with a pair of kernels against the host; then again, and backwards. Returns whether all is well.
template <class Real>
bool check_step(const SceneSpec& spec, int steps, const P2gVariant<Real>& a, const G2pVariant<Real>& b, bool exact) {
    Stepper<Real> s;
    s.init(spec);
    Reference host(spec);
    host.p = particles_of(s);
    for (int i = 0; i < steps; ++i) s.step(a, b), host.step();
    s.file();
    check(cudaDeviceSynchronize(), "step");
    const auto mine = particles_of(s);
    // single: ln J carries the rounding of v times dt / h per step, 1.2e-7 of the stride; the scale of ln J is 1e-2
    const double tolerance = sizeof(Real) == 8 ? 1e-12 : (spec.stride > 10 ? 5e-5 : 1e-5);
    const double d = difference(mine, host.p, spec, false);
    const std::uint64_t hash = s.hash();
    std::uint64_t again[3];
    for (int r = 0; r < 3; ++r) {
        s.init(spec);
        s.v.backwards = r == 1;
        s.refresh_every = r == 2 ? 2 : 0;
        for (int i = 0; i < steps; ++i) s.step(a, b);
        again[r] = s.hash();
        s.refresh_every = 0;
    }
    const bool same = again[0] == hash && again[1] == hash && again[2] == hash;
    const bool good = d <= tolerance && (same || !exact);
    std::printf("%s %s %-6s %2d steps of %4.1f %%: %-14s %-14s difference %.1e, %s\n", good ? "ok  " : "FAIL",
                spec.name, sizeof(Real) == 4 ? "single" : "double", steps, spec.stride, a.name, b.name, d,
                same ? "same to the bit again, backwards, refreshed" : "runs differ");
    if (!good) difference(mine, host.p, spec, true);
    return good;
}

/// Sums at the nodes of one P2G against the host.
template <class Real>
bool check_sums(SceneSpec spec, const P2gVariant<Real>& variant, const P2gVariant<Real>& base,
                const G2pVariant<Real>& b, bool exact) {
    spec.fold = false;
    Stepper<Real> s;
    s.init(spec);
    for (int i = 0; i < 3; ++i) s.step(base, b);
    s.file();
    Reference host(spec);
    host.p = particles_of(s);
    host.to_grid();
    std::vector<Quad<Real>> got[2];
    for (auto& g : got) {
        s.tiles_.poison(), s.sums_.poison();
        s.p2g(variant);
        if (!variant.sums) store_sums<<<(s.v.node_blocks + 3) / 4, 256>>>(s.v, s.sums_.data());
        check(cudaDeviceSynchronize(), variant.name);
        g = s.sums_.host();
    }
    double worst[3] = {}, scale[3] = {};
    for (int c = 0; c < s.v.node_blocks; ++c)
        for (int n = 0; n < cells; ++n) {
            int at[3];
            for (int a = 0; a < 3; ++a) at[a] = 4 * s.topology.position[std::size_t(c)][a] - 1 + ((n >> (2 * a)) & 3);
            if (at[2] > spec.cells[2] + 2) continue;
            const double* want = host.sums(at[0], at[1], at[2]);
            const Real* have = got[0][(std::size_t(c) * cells + std::size_t(n)) * 2].e;
            for (int q = 0; q < 7; ++q) {
                const int g = (q + 2) / 3;
                const double d = std::abs(double(have[q]) - want[q]);
                worst[g] = d <= worst[g] ? worst[g] : (std::isfinite(d) ? d : INFINITY);
                scale[g] = std::max(scale[g], std::abs(want[q]));
            }
        }
    double d = 0;
    if (!(worst[0] + worst[1] + worst[2] < 1e-4 * (scale[0] + scale[1] + scale[2])))
        std::printf("    mass %.2e of %.2e, momentum %.2e of %.2e, force %.2e of %.2e\n", worst[0], scale[0], worst[1],
                    scale[1], worst[2], scale[2]);
    for (int g = 0; g < 3; ++g) d = std::max(d, worst[g] / scale[g]);
    const bool same = std::memcmp(got[0].data(), got[1].data(), got[0].size() * sizeof(Quad<Real>)) == 0;
    const bool good = d <= (sizeof(Real) == 8 ? 1e-12 : 1e-5) && (same || !exact);
    std::printf("%s sums of %-16s %-6s difference %.1e, %s\n", good ? "ok  " : "FAIL", variant.name,
                sizeof(Real) == 4 ? "single" : "double", d, same ? "same to the bit again" : "runs differ");
    return good;
}

}  // namespace lab
