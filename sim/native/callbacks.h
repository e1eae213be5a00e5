/* The Python functions that C calls. */
void hw_onewire_received(void *handle, int first, const uint8_t *data, int bits, uint64_t cycle);
void hw_pin_edge(void *handle, int low, uint64_t cycle);
void hw_spi_selected(void *handle, uint64_t cycle);
void hw_spi_released(void *handle, uint64_t cycle);
void hw_spi_addressed(void *handle, uint8_t address, uint64_t cycle);
void hw_machine_sense(void *handle, int sensor, double felt);
double hw_machine_fed(void *handle);
void hw_machine_feel(void *handle);
