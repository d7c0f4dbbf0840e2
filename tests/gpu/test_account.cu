#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "gpu/kernels/seen.cuh"
#include "gpu/kernels/step_report.hpp"
#include "gpu/kernels/team.cuh"
#include "gpu/memory/array.hpp"

using namespace moraine;

namespace {

constexpr int threads = 128;

__global__ void add_all(const double* term, int n, Quantum quantum, ExactSum* sum) {
    for (int k = int(blockIdx.x * blockDim.x + threadIdx.x); k < n; k += int(gridDim.x * blockDim.x))
        gpu::add_exact(sum, quantum.of(term[k]));
}

/// Term k goes to sum k % 3.
__global__ void fold_all(const double* term, int n, Quantum quantum, ExactSum* sum) {
    ExactSum mine[3];
    for (int k = int(blockIdx.x * blockDim.x + threadIdx.x); k < n; k += int(gridDim.x * blockDim.x))
        mine[k % 3].add(quantum.of(term[k]));
    gpu::fold_sums(mine, sum);
}

/// Two of three lanes add to one of two sets of 2 sums: the term and half of it.
__global__ void add_some(const double* term, int n, Quantum quantum, ExactSum (*sets)[2]) {
    for (int k = int(blockIdx.x * blockDim.x + threadIdx.x); k < n; k += int(gridDim.x * blockDim.x)) {
        const double values[2] = {term[k], 0.5 * term[k]};
        if (k % 3 != 0) gpu::add_together(sets[k % 7 == 0], quantum, values);
    }
}

/// Item i is a block of cells with the work of `threads` threads.
__global__ void work_of_items(const double* work, int items, Quantum quantum, gpu::Account<3>* accounts) {
    __shared__ double scratch[threads / 32];
    for (int i = int(blockIdx.x); i < items; i += int(gridDim.x)) {
        const double sum = gpu::Team<3>::sum(work[i * threads + int(threadIdx.x)], scratch);
        if (threadIdx.x == 0) gpu::add_exact(&accounts[i % gpu::account_parts].work, quantum.of(sum));
        __syncthreads();
    }
}

template <class Real>
__global__ void outcomes(const Real* signal, const Real* moved, int n, gpu::Account<2>* accounts) {
    gpu::Seen<Real> mine;
    gpu::Account<2>& account = accounts[blockIdx.x % gpu::account_parts];
    for (int k = int(blockIdx.x * blockDim.x + threadIdx.x); k < n; k += int(gridDim.x * blockDim.x)) {
        mine.signal = max(mine.signal, signal[k]);
        mine.moved = max(mine.moved, moved[k]);
        if (k % 1000 == 7)
            gpu::note_fault(account, k % 2000 == 7 ? fault_far : fault_nan, std::uint64_t(5000000000ull - k));
        if (k % 3 == 0) ++mine.clamped;
    }
    mine.fold_into(account);
}

/// Terms of both signs from 1e-40 to 1e8.
std::vector<double> wild_terms(int n, unsigned seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> magnitude(-40, 8), sign(-1, 1);
    std::vector<double> terms;
    for (int k = 0; k < n; ++k) terms.push_back(std::copysign(std::pow(10.0, magnitude(random)), sign(random)));
    return terms;
}

bool same(const ExactSum& a, const ExactSum& b) {
    return a.high == b.high && a.low == b.low;
}

/// One particular account, not empty in any part.
gpu::Account<3> some_account(std::mt19937_64& random) {
    gpu::Account<3> a{};
    a.signal = random() >> 1, a.moved = random() >> 1, a.faulty_id = random() >> 8;
    a.faults = random() % 16, a.clamped = random() % 1000, a.lost_count = random() >> 20;
    const auto fill = [&](ExactSum& s) { s.high = std::int64_t(random()) >> 10, s.low = random(); };
    fill(a.work), fill(a.lost_mass);
    for (int i = 0; i < 3; ++i) fill(a.impulse[i]), fill(a.lost_momentum[i]), fill(a.lost_gravity_impulse[i]);
    return a;
}

void merge(gpu::Account<3>& a, const gpu::Account<3>& b) {
    a.signal = std::max(a.signal, b.signal), a.moved = std::max(a.moved, b.moved);
    a.faulty_id = std::min(a.faulty_id, b.faulty_id);
    a.faults |= b.faults, a.clamped += b.clamped, a.lost_count += b.lost_count;
    a.work.add(b.work), a.lost_mass.add(b.lost_mass);
    for (int i = 0; i < 3; ++i) {
        a.impulse[i].add(b.impulse[i]);
        a.lost_momentum[i].add(b.lost_momentum[i]), a.lost_gravity_impulse[i].add(b.lost_gravity_impulse[i]);
    }
}

gpu::Account<3> empty_account() {
    gpu::Account<3> a{};
    a.faulty_id = ~std::uint64_t(0);
    return a;
}

std::vector<gpu::Account<2>> outcome_accounts() {
    gpu::Array<gpu::Account<2>> accounts;
    accounts.resize(gpu::account_parts);
    gpu::empty_accounts(accounts.data(), nullptr);
    return accounts.host();
}

}  // namespace

TEST_CASE("atomic sums of wild terms are those of the host, to the bit, in any grid") {
    const int n = 50000;
    const Quantum quantum = Quantum::for_largest(1e9);
    const std::vector<double> terms = wild_terms(n, 3);
    gpu::Array<double> term;
    term.assign(terms);
    ExactSum all, part[3];
    for (int k = 0; k < n; ++k)
        all.add(quantum.of(terms[std::size_t(k)])), part[k % 3].add(quantum.of(terms[std::size_t(k)]));
    for (int grid : {1, 7, 200}) {
        gpu::Array<ExactSum> sums;
        sums.assign(std::vector<ExactSum>(4));
        add_all<<<grid, threads>>>(term.data(), n, quantum, sums.data());
        fold_all<<<grid, threads>>>(term.data(), n, quantum, sums.data() + 1);
        const std::vector<ExactSum> found = sums.host();
        CHECK(same(found[0], all));
        for (int i = 0; i < 3; ++i) CHECK(same(found[std::size_t(i) + 1], part[i]));
    }
}

TEST_CASE("lanes that are there together add to their sets of sums, to the bit, in any grid") {
    const int n = 50000;
    const Quantum quantum = Quantum::for_largest(1e9);
    const std::vector<double> terms = wild_terms(n, 5);
    gpu::Array<double> term;
    term.assign(terms);
    ExactSum expected[4];
    for (int k = 0; k < n; ++k)
        for (int i = 0; k % 3 != 0 && i < 2; ++i)
            expected[2 * (k % 7 == 0) + i].add(
                quantum.of(i == 0 ? terms[std::size_t(k)] : 0.5 * terms[std::size_t(k)]));
    for (int grid : {1, 7, 200}) {
        gpu::Array<ExactSum> sums;
        sums.assign(std::vector<ExactSum>(4));
        add_some<<<grid, threads>>>(term.data(), n, quantum, reinterpret_cast<ExactSum(*)[2]>(sums.data()));
        const std::vector<ExactSum> found = sums.host();
        for (int i = 0; i < 4; ++i) CHECK(same(found[std::size_t(i)], expected[i]));
    }
}

TEST_CASE("the work of a block is summed in one fixed tree, rounded, and added exactly, in any grid") {
    const int items = 300;
    const Quantum quantum = Quantum::for_largest(1e12);
    const std::vector<double> work = wild_terms(items * threads, 4);
    ExactSum expected;
    for (int i = 0; i < items; ++i) {
        double sum = 0;
        for (int w = 0; w < threads / 32; ++w) {
            double lane[32];
            std::memcpy(lane, work.data() + i * threads + 32 * w, sizeof(lane));
            for (int d = 16; d > 0; d /= 2)
                for (int k = 0; k < d; ++k) lane[k] += lane[k + d];
            sum = w == 0 ? lane[0] : sum + lane[0];
        }
        expected.add(quantum.of(sum));
    }
    gpu::Array<double> device;
    device.assign(work);
    for (int grid : {1, 64, 300}) {
        gpu::Array<gpu::Account<3>> accounts;
        accounts.resize(gpu::account_parts);
        gpu::empty_accounts(accounts.data(), nullptr);
        work_of_items<<<grid, threads>>>(device.data(), items, quantum, accounts.data());
        ExactSum found;
        for (const gpu::Account<3>& a : accounts.host()) found.add(a.work);
        CHECK(same(found, expected));
    }
}

TEST_CASE_TEMPLATE("outcomes fold to the largest values, the lowest faulty id and all faults", Real, float, double) {
    const int n = 20000;
    std::mt19937_64 random(6);
    std::uniform_real_distribution<double> any(0, 1e3);
    std::vector<Real> signal, moved;
    for (int k = 0; k < n; ++k) signal.push_back(Real(any(random))), moved.push_back(Real(any(random) * 1e-6));
    gpu::Array<Real> s, m;
    s.assign(signal), m.assign(moved);
    gpu::Array<gpu::Account<2>> accounts;
    accounts.assign(outcome_accounts());
    outcomes<<<90, threads>>>(s.data(), m.data(), n, accounts.data());
    gpu::Account<2> all{};
    all.faulty_id = ~std::uint64_t(0);
    for (const gpu::Account<2>& a : accounts.host()) {
        all.signal = std::max(all.signal, a.signal), all.moved = std::max(all.moved, a.moved);
        all.faulty_id = std::min(all.faulty_id, a.faulty_id);
        all.faults |= a.faults, all.clamped += a.clamped;
    }
    double found[2];
    std::memcpy(&found[0], &all.signal, 8), std::memcpy(&found[1], &all.moved, 8);
    CHECK(found[0] == double(*std::max_element(signal.begin(), signal.end())));
    CHECK(found[1] == double(*std::max_element(moved.begin(), moved.end())));
    CHECK(all.faults == (fault_far | fault_nan));
    CHECK(all.faulty_id == 5000000000ull - 19007);
    CHECK(all.clamped == (n + 2) / 3);
}

TEST_CASE("a report is the fold of all accounts with the counts of the binning, and leaves the accounts empty") {
    std::mt19937_64 random(8);
    std::vector<gpu::Account<3>> parts;
    gpu::Account<3> expected = empty_account();
    for (int i = 0; i < gpu::account_parts; ++i) parts.push_back(some_account(random)), merge(expected, parts.back());
    gpu::Array<gpu::Account<3>> accounts;
    accounts.assign(parts);
    gpu::Array<std::uint32_t> counts;
    counts.assign({12345u, 6u, 7u, 1u});
    gpu::Array<gpu::Counters> counters;
    counters.assign({{8, 9, 10, {11, 12}}});
    gpu::Report<3>* report = nullptr;
    gpu::check(cudaHostAlloc(&report, sizeof(*report), cudaHostAllocMapped), "Allocating pinned memory");
    gpu::fold_report<3>({accounts.data(), counts.data(), counts.data() + 1, counts.data() + 3, counters.data(), report},
                        nullptr);
    gpu::check(cudaDeviceSynchronize(), "Reporting");
    CHECK(std::memcmp(&report->account, &expected, sizeof(expected)) == 0);
    CHECK(report->particles == 12345);
    CHECK(report->boundary == 6);
    CHECK(report->interior == 7);
    CHECK(report->occupied() == 13);
    CHECK(report->stored == 10);
    CHECK(report->migration_bound[0] == 11);
    CHECK(report->migration_bound[1] == 12);
    CHECK(report->in_guard_layer == 1);
    CHECK(counters.host().front().migration_bound[0] == 0);
    CHECK(counters.host().front().migration_bound[1] == 0);
    CHECK(counters.host().front().stored == 10);
    const gpu::Account<3> empty = empty_account();
    for (const gpu::Account<3>& a : accounts.host()) CHECK(std::memcmp(&a, &empty, sizeof(empty)) == 0);
    cudaFreeHost(report);
}
