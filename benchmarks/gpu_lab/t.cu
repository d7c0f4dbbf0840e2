#include "p2g_slices.cuh"
#include "filing.cuh"
template __global__ void lab::p2g_staged<float,3,1,3>(const __grid_constant__ lab::View<float>);
template __global__ void lab::p2g_staged<float,3,2,2>(const __grid_constant__ lab::View<float>);
template __global__ void lab::p2g_direct<float,3>(const __grid_constant__ lab::View<float>);
template __global__ void lab::p2g_staged<double,3,1,1>(const __grid_constant__ lab::View<double>);
template __global__ void lab::p2g_staged<double,3,2,1>(const __grid_constant__ lab::View<double>);
template __global__ void lab::collect_leavers<float>(lab::View<float>, lab::Filing);
template __global__ void lab::count_next<float>(lab::View<float>, lab::Filing);
template __global__ void lab::fill_next<float>(lab::View<float>, lab::Filing);
