#pragma once
// Where a run computes: on the host or on CUDA devices, one per rank. A program without device code has the host only.

#include <functional>
#include <memory>
#include <string>

#include "comm/comm.hpp"
#include "comm/engine.hpp"

namespace moraine {

struct DeviceChoice {
    bool cuda = false;
    std::string words;  ///< for the user: what was chosen, and why
};

/// `wanted` is --device: cpu, cuda, or auto (CUDA where every rank finds a device). The ranks of a machine are given
/// its devices in turn. Throws InputError, the same on all ranks, where cuda is wanted and cannot be had. Collective.
DeviceChoice choose_device(const std::string& wanted, const Comm& comm);

/// Throws InputError if the device that was chosen has less than `bytes` free. Not collective.
void check_device_memory(double bytes);

template <class Real, int Dim>
using DeviceEngineMaker = std::function<std::unique_ptr<Engine<Real, Dim>>(const Method<Host, Real, Dim>&)>;

/// Makes engines on the device that choose_device() gave to this rank. The scene must outlive what is made.
template <class Real, int Dim>
DeviceEngineMaker<Real, Dim> device_engine_maker(const Scene& scene);

}  // namespace moraine
