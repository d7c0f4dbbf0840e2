// The program without device code.

#include "core/error.hpp"
#include "device.hpp"

namespace moraine {

DeviceChoice choose_device(const std::string& wanted, const Comm&) {
    if (wanted == "cuda")
        throw InputError("This program was built without CUDA (--device cuda needs it). Use --device cpu?");
    return {false, "Computing on the host (this program was built without CUDA)"};
}

void check_device_memory(double) {}

template <class Real, int Dim>
DeviceEngineMaker<Real, Dim> device_engine_maker(const Scene&) {
    return nullptr;
}

template DeviceEngineMaker<float, 2> device_engine_maker<float, 2>(const Scene&);
template DeviceEngineMaker<float, 3> device_engine_maker<float, 3>(const Scene&);
template DeviceEngineMaker<double, 2> device_engine_maker<double, 2>(const Scene&);
template DeviceEngineMaker<double, 3> device_engine_maker<double, 3>(const Scene&);

}  // namespace moraine
