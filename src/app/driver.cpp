#include "app/driver.hpp"

#include "app/driver.ipp"

namespace moraine {

namespace {

template <class Real>
void run_precision(const Scene& scene, const Options& options, const Comm& comm, const DeviceChoice& device) {
    if (scene.dimensions == 2)
        Driver<Real, 2>(scene, options, comm, device).run();
    else
        Driver<Real, 3>(scene, options, comm, device).run();
}

}  // namespace

void run_scene(const Scene& scene, const Options& options, const Comm& comm, const DeviceChoice& device) {
    if (scene.precision == Precision::double_)
        run_precision<double>(scene, options, comm, device);
    else
        run_precision<float>(scene, options, comm, device);
}

}  // namespace moraine
