//! Physics of the outside world.
