#include "gpu/engine.hpp"

#include "gpu/compile/kernel_store.hpp"

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
    : Engine<Real, Dim>({properties_of_device().name, true, compiler_of_device()}),
      scene_(scene),
      method_(method),
      memory_(properties_of_device().totalGlobalMem),
      share_(method.needs, method.stencil.width),
      epoch_(method.stencil.width, comm.size() > 1),
      store_(method.needs, refresh_interval, static_cast<std::size_t>(properties_of_device().l2CacheSize)),
      kernels_(scene),
      bodies_(scene, method) {
    if (kernels_.key.way == GatherWay::by_material)
        materials_ = std::make_unique<MaterialGathers<Real, Dim>>(scene, kernels_.key, bodies_.material_of.data());
    if (kernels_.key.surfaces) surfaces_ = std::make_unique<SurfaceState<Real, Dim>>(kernels_.key, method, scene.cell);
    contact_.at_surfaces = kernels_.key.surfaces;
    fluid_.start(method, scene.bodies.size(), surfaces_ != nullptr);
    light_.start(method, scene.bodies.size());
    if (scene.sleep.on)
        sleepers_ =
            std::make_unique<DeviceSleepers<Real, Dim>>(scene, kernels_.key, method, bodies_.material_of.data());
    if (comm.size() > 1) exchange_ = std::make_unique<Exchange<Real, Dim>>(comm, *transports, takes_means(method));
    if (method.needs.loads) {
        added_.loads = std::make_unique<DeviceLoads<Real, Dim>>(kernels_.key);
        added_.loads->take(method.tractions());
    }
    reports_.start(stream_);
}

template <class Real, int Dim>
DeviceEngine<Real, Dim>::~DeviceEngine() = default;

template <class Real, int Dim>
View<Real, Dim> DeviceEngine<Real, Dim>::view() const {
    View<Real, Dim> v{};
    v.table = epoch_.table.view();
    v.list = epoch_.lists.view();
    v.grid = {epoch_.lists.tile_of(), reinterpret_cast<Real*>(epoch_.tiles.data()), epoch_.node_of.data(),
              reinterpret_cast<Real*>(epoch_.nodes.data())};
    v.p = lead_ && lead_->captured_columns() ? *lead_->captured_columns() : store_.rows.view();
    if (surfaces_ && exchange_) v.table.kept_nodes = surfaces_->near_of();
    v.context = method_.context;
    v.context.half_size = bodies_.half_size.data();
    v.moves = epoch_.lists.moves();
    v.changed = epoch_.lists.changed();
    v.accounts = reports_.accounts.data();
    return v;
}

template class DeviceEngine<float, 2>;
template class DeviceEngine<float, 3>;
template class DeviceEngine<double, 2>;
template class DeviceEngine<double, 3>;

}  // namespace moraine::gpu
