#pragma once
// The ranks of a run: a thin, typed face of one MPI communicator.
//
// Owns a duplicate of the communicator it is given, so that messages cannot meet those of others.
// Errors of MPI end the job (MPI_ERRORS_ARE_FATAL): a lost rank cannot be waited for.

#include <mpi.h>

#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace moraine {

class Comm {
  public:
    /// Collective.
    explicit Comm(MPI_Comm parent);
    ~Comm();
    Comm(const Comm&) = delete;
    Comm& operator=(const Comm&) = delete;

    int rank() const { return rank_; }
    int size() const { return size_; }
    bool is_root() const { return rank_ == 0; }
    MPI_Comm handle() const { return comm_; }

    /// This rank among those of its machine, and how many they are. Collective.
    struct Neighbours {
        int rank;
        int size;
    };
    Neighbours on_this_machine() const;

    /// Collective.
    void barrier() const;
    double min(double value) const;
    double max(double value) const;
    double sum(double value) const;
    std::int64_t max(std::int64_t value) const;
    std::int64_t sum(std::int64_t value) const;
    std::uint64_t sum(std::uint64_t value) const;  ///< modulo 2^64
    void sum(std::span<std::int64_t> values) const;
    void unite(std::span<std::uint64_t> bits) const;  ///< the bits that any rank has
    std::string broadcast(const std::string& text, int root = 0) const;
    /// Rank 0's.
    template <class T>
    T of_root(T value) const {
        static_assert(std::is_trivially_copyable_v<T>);
        MPI_Bcast(&value, static_cast<int>(sizeof value), MPI_BYTE, 0, comm_);
        return value;
    }

    /// All ranks' rows, rank by rank. `counts`, if given, gets the rows of each rank. Collective.
    template <class T>
    std::vector<T> all_gather(const std::vector<T>& mine, std::vector<std::int64_t>* counts = nullptr) const {
        static_assert(std::is_trivially_copyable_v<T>);
        std::vector<std::int64_t> bytes = gather_counts(static_cast<std::int64_t>(mine.size() * sizeof(T)));
        std::int64_t total = 0;
        for (auto& b : bytes) total += b;
        std::vector<T> all(static_cast<std::size_t>(total) / sizeof(T));
        gather_bytes(mine.data(), bytes, all.data());
        if (counts) {
            *counts = bytes;
            for (auto& c : *counts) c /= static_cast<std::int64_t>(sizeof(T));
        }
        return all;
    }

    /// Rows to all ranks, so many to each; returns those for this one, rank by rank. `counts` becomes how many came
    /// from each. Collective.
    template <class T>
    std::vector<T> exchange(const std::vector<T>& rows, std::vector<std::int64_t>& counts) const {
        static_assert(std::is_trivially_copyable_v<T>);
        const std::vector<std::int64_t> sent = counts;
        counts = swap_counts(sent);
        std::int64_t total = 0;
        for (auto n : counts) total += n;
        std::vector<T> all(static_cast<std::size_t>(total));
        exchange_rows(rows.data(), sent, all.data(), counts, sizeof(T));
        return all;
    }
    /// The same where both know how many rows there are, of so many values each. Collective.
    template <class T>
    void exchange(const std::vector<T>& rows, const std::vector<std::int64_t>& sent, std::vector<T>& into,
                  const std::vector<std::int64_t>& received, std::size_t values) const {
        static_assert(std::is_trivially_copyable_v<T>);
        exchange_rows(rows.data(), sent, into.data(), received, values * sizeof(T));
    }

    /// Over ranks, element by element, of what is added without regard to order (core/data/exact_sum.hpp, maxima): as
    /// many elements on every rank; one reduction, none of no elements. Collective.
    template <class Sum>
    std::vector<Sum> exact_sums(const std::vector<Sum>& mine) const {
        static_assert(std::is_trivially_copyable_v<Sum>);
        std::vector<Sum> sums = mine;
        const auto add = [](void* in, void* in_out, int* n, MPI_Datatype*) {
            for (int k = 0; k < *n; ++k) static_cast<Sum*>(in_out)[k].add(static_cast<const Sum*>(in)[k]);
        };
        if (!sums.empty()) reduce(sums.data(), sums.size(), sizeof(Sum), add);
        return sums;
    }
    template <class Sum>
    Sum exact_sum(const Sum& mine) const {
        return exact_sums(std::vector<Sum>{mine}).front();
    }

    /// If any rank says something, every rank throws it: the words of the lowest such rank. Collective.
    template <class Error>
    void agree_no_error(const std::string& mine) const {
        const std::string message = first_words(mine);
        if (!message.empty()) throw Error(message);
    }

  private:
    void reduce(void* rows, std::size_t count, std::size_t bytes, MPI_User_function* add) const;
    std::vector<std::int64_t> gather_counts(std::int64_t mine) const;
    void gather_bytes(const void* mine, const std::vector<std::int64_t>& bytes, void* all) const;
    std::vector<std::int64_t> swap_counts(const std::vector<std::int64_t>& mine) const;
    void exchange_rows(const void* rows, const std::vector<std::int64_t>& sent, void* into,
                       const std::vector<std::int64_t>& received, std::size_t bytes) const;
    std::string first_words(const std::string& mine) const;

    MPI_Comm comm_ = MPI_COMM_NULL;
    int rank_ = 0;
    int size_ = 1;
};

}  // namespace moraine
