#pragma once
// The host as a space to compute in: arrays, loops over items and over blocks, prefix sums.
//
// A space is these verbs and no more; the device has the same ones. Loops over blocks run on OpenMP
// threads with dynamic chunks: no result depends on who ran which block.

#include <omp.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "core/data/vec.hpp"

namespace moraine {

/// One thread that does a whole block. Device teams have the same two verbs.
struct SoloTeam {
    template <class F>
    MORAINE_HD void each(int n, const F& f) const {
        for (int i = 0; i < n; ++i) f(i);
    }
    MORAINE_HD void sync() const {}
};

struct Host {
    /// Contiguous memory that grows and is not initialised (vector would write zeros first).
    template <class T>
    class Array {
      public:
        std::size_t size() const { return size_; }
        std::size_t capacity() const { return capacity_; }
        T* data() { return data_.get(); }
        const T* data() const { return data_.get(); }
        T& operator[](std::size_t i) { return data_[i]; }
        const T& operator[](std::size_t i) const { return data_[i]; }
        std::span<const T> span() const { return {data_.get(), size_}; }

        /// New elements hold anything. Grows by a sixteenth more than asked, to keep memory low.
        void resize(std::size_t n) {
            if (n > capacity_) reserve(capacity_ == 0 ? n : n + n / 16);
            size_ = n;
        }
        void reserve(std::size_t n) {
            if (n <= capacity_) return;
            std::unique_ptr<T[]> grown(new T[n]);
            if (size_ > 0) std::memcpy(static_cast<void*>(grown.get()), data_.get(), size_ * sizeof(T));
            data_ = std::move(grown);
            capacity_ = n;
        }
        void assign(std::size_t n, const T& value) {
            resize(n);
            std::fill_n(data_.get(), n, value);
        }
        void assign(const std::vector<T>& from) {
            resize(from.size());
            std::copy(from.begin(), from.end(), data_.get());
        }
        void release() { data_.reset(), size_ = capacity_ = 0; }
        void swap(Array& other) {
            data_.swap(other.data_);
            std::swap(size_, other.size_);
            std::swap(capacity_, other.capacity_);
        }

      private:
        std::unique_ptr<T[]> data_;
        std::size_t size_ = 0;
        std::size_t capacity_ = 0;
    };

    /// kernel(i) for i in [0, n).
    template <class Kernel>
    static void launch(std::int64_t n, const Kernel& kernel) {
#pragma omp parallel for schedule(dynamic, 16) if (n > 64)
        for (std::int64_t i = 0; i < n; ++i) kernel(static_cast<int>(i));
    }

    /// kernel(team, i, scratch) for i in [0, n), one scratch of type Kernel::Scratch per thread.
    template <class Kernel>
    static void launch_teams(std::int64_t n, const Kernel& kernel) {
#pragma omp parallel if (n > 1)
        {
            const auto scratch = std::make_unique<typename Kernel::Scratch>();
#pragma omp for schedule(dynamic, 4)
            for (std::int64_t i = 0; i < n; ++i) kernel(SoloTeam{}, static_cast<int>(i), *scratch);
        }
    }

    /// first[i] = sum of count[0..i); first has n + 1 entries. Returns the total.
    template <class Count, class First>
    static First scan(std::size_t n, const Count* count, First* first) {
        First sum = 0;
        for (std::size_t i = 0; i < n; ++i) {
            first[i] = sum;
            sum += static_cast<First>(count[i]);
        }
        first[n] = sum;
        return sum;
    }
};

}  // namespace moraine
