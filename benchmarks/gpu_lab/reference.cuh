#pragma once
// The same step in double on the host, plainly: every particle adds to a dense grid, folding its own weights.

#include <vector>

#include "scene.cuh"

namespace lab {

struct ReferenceParticle {
    double local[3];  ///< (x - min)/h + 1/2
    double v[3];
    double mass, volume, ln_J, xi;
    Sym<double, 3> stress;
};

class Reference {
  public:
    explicit Reference(const SceneSpec& s) : scene_(s), walls_(walls_of<double>(s)), law_(law_of<double>()) {
        for (int a = 0; a < 3; ++a) size_[a] = a < 2 ? s.cells[a] : s.cells[a] + 4;
        sums_.resize(std::size_t(size_[0]) * std::size_t(size_[1]) * std::size_t(size_[2]) * 7);
        values_.resize(sums_.size());
    }

    std::vector<ReferenceParticle> p;

    /// Sums of node (x, y, z): mass, momentum, force.
    const double* sums(int x, int y, int z) const { return sums_.data() + 7 * node(x, y, z); }

    void to_grid() {
        std::fill(sums_.begin(), sums_.end(), 0.0);
        for (const ReferenceParticle& q : p)
            each_node(q, [&](std::size_t n, double w, const double* g) {
                double* s = sums_.data() + 7 * n;
                s[0] += w * q.mass;
                for (int a = 0; a < 3; ++a) {
                    s[1 + a] += w * q.mass * q.v[a];
                    for (int b = 0; b < 3; ++b) s[4 + a] -= q.volume * q.stress(a, b) * g[b];
                }
            });
    }

    void step() {
        to_grid();
        solve();
        for (ReferenceParticle& q : p) update(q);
    }

  private:
    std::size_t node(int x, int y, int z) const {
        const auto wrap = [](int i, int n) { return std::size_t((i % n + n) % n); };
        return wrap(x, size_[0]) +
               std::size_t(size_[0]) * (wrap(y, size_[1]) + std::size_t(size_[1]) * std::size_t(z + 1));
    }

    template <class F>
    void each_node(const ReferenceParticle& q, const F& f) const {
        double w[3][3], d[3][3];
        int base[3];
        for (int a = 0; a < 3; ++a) {
            const double cell = std::floor(q.local[a]);
            base[a] = int(cell) - 1;
            Quadratic::weights(q.local[a] - cell, 0.0, w[a], d[a]);
            fold(a, base[a], w[a], d[a]);
            for (int i = 0; i < 3; ++i) d[a][i] /= SceneSpec::h;
        }
        for (int k = 0; k < 3; ++k)
            for (int j = 0; j < 3; ++j)
                for (int i = 0; i < 3; ++i) {
                    const double g[3] = {d[0][i] * w[1][j] * w[2][k], w[0][i] * d[1][j] * w[2][k],
                                         w[0][i] * w[1][j] * d[2][k]};
                    f(node(base[0] + i, base[1] + j, base[2] + k), w[0][i] * w[1][j] * w[2][k], g);
                }
    }

    /// The ghost's weight goes to the two nodes that it follows.
    void fold(int a, int base, double* w, double* d) const {
        for (int s = 0; s < 2; ++s) {
            const int in = s == 0 ? 1 : -1, ghost = walls_.plane[a][s] - in - base;
            if (!walls_.fold[a][s] || ghost < 0 || ghost > 2) continue;
            for (double* q : {w, d}) q[ghost + in] += 2 * q[ghost], q[ghost + 2 * in] -= q[ghost], q[ghost] = 0;
        }
    }

    void solve() {
        for (int z = -1; z < size_[2] - 1; ++z)
            for (int y = 0; y < size_[1]; ++y)
                for (int x = 0; x < size_[0]; ++x) {
                    const double* s = sums(x, y, z);
                    double* out = values_.data() + 7 * node(x, y, z);
                    std::fill(out, out + 7, 0.0);
                    if (!(s[0] > 0)) continue;
                    Vec<double, 3> u;
                    for (int a = 0; a < 3; ++a)
                        u[a] = s[1 + a] / s[0] + SceneSpec::dt * (s[4 + a] / s[0] + (a == 2 ? -9.81 : 0));
                    const int at[3] = {x, y, z};
                    walls_.constrain(at, u);
                    for (int a = 0; a < 3; ++a) out[a] = u[a], out[3 + a] = u[a] - s[1 + a] / s[0];
                }
    }

    void update(ReferenceParticle& q) const {
        double v[3] = {0, 0, 0};
        Mat<double, 3> dL = zero_mat<double, 3>();
        each_node(q, [&](std::size_t n, double w, const double* g) {
            const double* o = values_.data() + 7 * n;
            for (int a = 0; a < 3; ++a) {
                v[a] += w * o[a];
                q.v[a] += w * o[3 + a];
                for (int b = 0; b < 3; ++b) dL(a, b) += SceneSpec::dt * o[a] * g[b];
            }
        });
        for (int a = 0; a < 3; ++a) {
            q.local[a] += SceneSpec::dt * v[a] / SceneSpec::h;
            if (a == 2) continue;
            if (q.local[a] < 0) q.local[a] += scene_.cells[a];
            if (q.local[a] >= scene_.cells[a]) q.local[a] -= scene_.cells[a];
        }
        const StrainIncrement<double, 3> step = strain_increment(dL, SceneSpec::dt);
        PointState<double, 3> state;
        state.stress = q.stress;
        state.ln_J = q.ln_J + step.volumetric;
        state.history[0] = q.xi;
        law_.update(step, state);
        q.stress = state.stress, q.ln_J = state.ln_J, q.xi = state.history[0];
        q.volume = q.mass / SceneSpec::density * std::exp(q.ln_J);
    }

    SceneSpec scene_;
    Walls<double, 3> walls_;
    VonMises<double> law_;
    int size_[3];
    std::vector<double> sums_, values_;
};

}  // namespace lab
