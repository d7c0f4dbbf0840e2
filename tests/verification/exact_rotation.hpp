#pragma once
// E7: a free square that turns and drifts, v = V + w x r. Angular momentum about its centre and energy stay;
// stresses are those that hold it together, of the order rho w^2 a^2.
//
// Angular momentum of a transfer with an affine field (Jiang et al. 2015) counts that field too:
//   L = sum m (x - X) x (v - V) + sum m D (C_yx - C_xy),   D = h^2/4 (quadratic), h^2/3 (cubic)

namespace moraine::verification {

struct Spin {
    double side = 1;        ///< a [m]
    double density = 1550;  ///< [kg/m3]
    double rate = 1;        ///< w [1/s]
    double drift = 0.5;     ///< V, along x and y [m/s]

    double mass() const { return density * side * side; }
    double angular_momentum() const { return mass() * side * side / 6 * rate; }
    double energy() const { return 0.5 * angular_momentum() * rate + mass() * drift * drift; }
};

}  // namespace moraine::verification
