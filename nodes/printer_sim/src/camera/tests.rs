//! Laws of the camera.
