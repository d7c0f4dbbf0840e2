#include "gpu/engine.hpp"

#include <algorithm>

#include "gpu/compile/kernel_store.hpp"
#include "gpu/kernels/programs.hpp"

namespace moraine::gpu {

namespace {

cudaDeviceProp properties_of_device() {
    int device = 0;
    cudaDeviceProp properties{};
    check(cudaGetDevice(&device), "Asking for the device");
    check(cudaGetDeviceProperties(&properties, device), "Asking the device what it is");
    return properties;
}

}  // namespace

template <class Real, int Dim>
DeviceEngine<Real, Dim>::DeviceEngine(const Scene& scene, const Comm& comm, const Method<Host, Real, Dim>& method,
                                      const TransportFactory* transports, int refresh_interval)
    : scene_(scene),
      method_(method),
      name_(properties_of_device().name),
      memory_(properties_of_device().totalGlobalMem),
      key_(device_kernel_key<Real, Dim>(scene)),
      share_(method.needs, method.stencil.width),
      particles_(method.needs),
      refresh_clock_(refresh_interval),
      cache_(static_cast<std::size_t>(properties_of_device().l2CacheSize)) {
    check(cudaGetDevice(&device_), "Asking for the device");
    choose_kernels();
    half_size_.assign(method.context.half_size, scene.bodies.size());
    std::vector<std::uint16_t> materials;
    for (const BodySpec& body : scene.bodies) materials.push_back(static_cast<std::uint16_t>(body.material));
    material_of_.assign(materials);
    if (key_.way == GatherWay::by_material)
        materials_ = std::make_unique<MaterialGathers<Real, Dim>>(scene, key_, material_of_.data());
    take_fluids();
    if (method.averaged()) averaged_.assign(method.averaged(), scene.bodies.size());
    if (method.stiffness()) {
        stiffness_.assign(method.stiffness(), scene.bodies.size());
        for (std::size_t b = 0; b < scene.bodies.size(); ++b)
            full_mass_ = std::max(full_mass_, method.stiffness()[b].full_mass);
        limited_count_.resize(2 * LimitedBlocks::lists);
    }
    if (scene.sleep.on)
        sleepers_ = std::make_unique<DeviceSleepers<Real, Dim>>(scene, key_, method, material_of_.data());
    if (comm.size() > 1) exchange_ = std::make_unique<Exchange<Real, Dim>>(comm, *transports, takes_means());
    counters_.assign(std::vector<Counters>{{}});
    accounts_.resize(account_parts);
    empty_accounts(accounts_.data(), stream_);
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::choose_kernels() {
    KernelStore::instance().prepare(programs_of(key_));
    p2g_ = P2g<Real, Dim>(key_, takes_means());
    nodes_kernel_ = Nodes<Real, Dim>(key_);
    if (method_.grid_bulk()) pressure_kernels_ = Pressure<Real, Dim>(key_);
    if (key_.light_nodes) find_limited_ = FindLimited<Real, Dim>(key_);
    if (key_.way == GatherWay::fused) {
        gather_.emplace(key_, scene_.materials.front(), 0);
        return;
    }
    gather_.emplace(key_);
    for (std::size_t m = 0; m < scene_.materials.size(); ++m) stress_.emplace_back(key_, scene_.materials[m], m);
}

template <class Real, int Dim>
View<Real, Dim> DeviceEngine<Real, Dim>::view() const {
    View<Real, Dim> v{};
    v.table = tables_.view();
    v.list = lists_.view();
    v.grid = {lists_.tile_of(), reinterpret_cast<Real*>(tiles_.data()), node_of_.data(),
              reinterpret_cast<Real*>(nodes_.data())};
    v.p = columns_of_lead_ ? *columns_of_lead_ : particles_.view();
    v.context = method_.context;
    v.context.half_size = half_size_.data();
    v.moves = lists_.moves();
    v.changed = lists_.changed();
    v.accounts = accounts_.data();
    return v;
}

template class DeviceEngine<float, 2>;
template class DeviceEngine<float, 3>;
template class DeviceEngine<double, 2>;
template class DeviceEngine<double, 3>;

}  // namespace moraine::gpu
