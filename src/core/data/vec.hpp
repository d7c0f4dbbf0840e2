#pragma once
// Small vectors and tensors by value, for host and device.
//
// Vec: Dim numbers. Mat: Dim x Dim, row first, m(i, j). Sym: a symmetric tensor; in plane strain it
// keeps the out-of-plane normal component, because a stress there is not zero:
//   2-D: xx yy zz xy        3-D: xx yy zz xy yz zx
// Plain aggregates, so that a column of them can be copied as bytes.

#if defined(__CUDACC__)
#define MORAINE_HD __host__ __device__ __forceinline__
#define MORAINE_INLINE
#define MORAINE_HD_RARE __host__ __device__ __noinline__  // its registers are no burden to who calls it
#else
#define MORAINE_HD inline __attribute__((always_inline))
#define MORAINE_INLINE __attribute__((always_inline))  // of a lambda on the host
#define MORAINE_HD_RARE __attribute__((noinline))
#endif

namespace moraine {

template <class Real, int Dim>
struct Vec {
    Real e[Dim];

    MORAINE_HD Real& operator[](int i) { return e[i]; }
    MORAINE_HD const Real& operator[](int i) const { return e[i]; }
};

template <class Real, int Dim>
struct Mat {
    Real e[Dim][Dim];

    MORAINE_HD Real& operator()(int i, int j) { return e[i][j]; }
    MORAINE_HD const Real& operator()(int i, int j) const { return e[i][j]; }
};

template <class Real, int Dim>
struct Sym {
    static constexpr int size = Dim == 2 ? 4 : 6;
    Real e[size];

    /// Position of component (i, j) in e; i, j < 3, and for 2-D not (x, z) or (y, z).
    static constexpr MORAINE_HD int index(int i, int j) {
        if (i == j) return i;
        if (Dim == 2) return 3;
        return i + j == 1 ? 3 : (i + j == 3 ? 4 : 5);
    }
    MORAINE_HD Real& operator[](int k) { return e[k]; }
    MORAINE_HD const Real& operator[](int k) const { return e[k]; }
    MORAINE_HD Real operator()(int i, int j) const { return e[index(i, j)]; }
    MORAINE_HD Real trace() const { return e[0] + e[1] + e[2]; }
};

template <class Real, int Dim>
MORAINE_HD Vec<Real, Dim> zero_vec() {
    Vec<Real, Dim> v;
    for (int i = 0; i < Dim; ++i) v[i] = Real(0);
    return v;
}

template <class Real, int Dim>
MORAINE_HD Mat<Real, Dim> zero_mat() {
    Mat<Real, Dim> m;
    for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j) m(i, j) = Real(0);
    return m;
}

template <class Real, int Dim>
MORAINE_HD Sym<Real, Dim> zero_sym() {
    Sym<Real, Dim> s;
    for (int k = 0; k < Sym<Real, Dim>::size; ++k) s[k] = Real(0);
    return s;
}

template <class Real, int Dim>
MORAINE_HD Mat<Real, Dim> identity() {
    Mat<Real, Dim> m = zero_mat<Real, Dim>();
    for (int i = 0; i < Dim; ++i) m(i, i) = Real(1);
    return m;
}

template <class Real, int Dim>
MORAINE_HD Mat<Real, Dim> operator*(const Mat<Real, Dim>& a, const Mat<Real, Dim>& b) {
    Mat<Real, Dim> m = zero_mat<Real, Dim>();
    for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j)
            for (int k = 0; k < Dim; ++k) m(i, j) += a(i, k) * b(k, j);
    return m;
}

template <class Real>
MORAINE_HD Real determinant(const Mat<Real, 2>& m) {
    return m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0);
}

template <class Real>
MORAINE_HD Real determinant(const Mat<Real, 3>& m) {
    return m(0, 0) * (m(1, 1) * m(2, 2) - m(1, 2) * m(2, 1)) - m(0, 1) * (m(1, 0) * m(2, 2) - m(1, 2) * m(2, 0)) +
           m(0, 2) * (m(1, 0) * m(2, 1) - m(1, 1) * m(2, 0));
}

template <class Real>
MORAINE_HD Mat<Real, 2> inverse(const Mat<Real, 2>& m) {
    const Real r = Real(1) / determinant(m);
    return {{{m(1, 1) * r, -m(0, 1) * r}, {-m(1, 0) * r, m(0, 0) * r}}};
}

template <class Real>
MORAINE_HD Mat<Real, 3> inverse(const Mat<Real, 3>& m) {
    const Real r = Real(1) / determinant(m);
    Mat<Real, 3> n;
    for (int i = 0; i < 3; ++i) {
        const int a = (i + 1) % 3;
        const int b = (i + 2) % 3;
        for (int j = 0; j < 3; ++j) {
            const int c = (j + 1) % 3;
            const int d = (j + 2) % 3;
            n(j, i) = (m(a, c) * m(b, d) - m(a, d) * m(b, c)) * r;
        }
    }
    return n;
}

/// Q S Qᵀ. In plane strain Q turns the plane and zz stays.
template <class Real, int Dim>
MORAINE_HD Sym<Real, Dim> rotated(const Sym<Real, Dim>& s, const Mat<Real, Dim>& q) {
    Mat<Real, Dim> full;
    for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j) full(i, j) = s(i, j);
    const Mat<Real, Dim> qs = q * full;
    Sym<Real, Dim> r = s;
    for (int i = 0; i < Dim; ++i)
        for (int j = i; j < Dim; ++j) {
            Real sum = Real(0);
            for (int k = 0; k < Dim; ++k) sum += qs(i, k) * q(j, k);
            r[Sym<Real, Dim>::index(i, j)] = sum;
        }
    return r;
}

}  // namespace moraine
