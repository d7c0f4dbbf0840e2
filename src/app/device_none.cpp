// The program without device code.

#include "app/device.hpp"
#include "core/data/error.hpp"

namespace moraine {

bool wants_device(const std::string& wanted, const Comm&) {
    return wanted == "cuda";
}

DeviceChoice choose_device(const std::string& wanted, const Comm&, const std::string& transport) {
    if (wanted == "cuda")
        throw InputError("This program was built without CUDA (--device cuda needs it). Use --device cpu?");
    if (transport != "auto" && transport != "host")
        throw InputError("This program was built without CUDA (--transport " + transport +
                         " moves device memory). Use --transport host?");
    return {false, "Computing on the host (this program was built without CUDA)", nullptr, "host"};
}

void keep_kernels(const std::string&, bool) {}

std::string compile_kernels(const Scene&, const std::string&, const std::vector<int>&) {
    throw InputError("This program was built without CUDA (it has no device kernels). Build it with nvcc?");
}

void check_device_memory(double, const Comm&) {}

Profiler device_profiler() {
    return {};
}

template <class Real, int Dim>
DeviceEngineMaker<Real, Dim> device_engine_maker(const Scene&, const Comm&, const DeviceChoice&) {
    return nullptr;
}

template DeviceEngineMaker<float, 2> device_engine_maker<float, 2>(const Scene&, const Comm&, const DeviceChoice&);
template DeviceEngineMaker<float, 3> device_engine_maker<float, 3>(const Scene&, const Comm&, const DeviceChoice&);
template DeviceEngineMaker<double, 2> device_engine_maker<double, 2>(const Scene&, const Comm&, const DeviceChoice&);
template DeviceEngineMaker<double, 3> device_engine_maker<double, 3>(const Scene&, const Comm&, const DeviceChoice&);

}  // namespace moraine
