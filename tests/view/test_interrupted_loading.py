"""An interruption while the libraries that draw are loaded waits until they are."""

import signal

import pytest

from flexmb.view import graphics


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals_wait_for_the_libraries(number):
    before, done = signal.signal(number, signal.default_int_handler), []

    def loading():
        with graphics._signals_waiting():
            signal.raise_signal(number)
            done.append(True)

    try:
        with pytest.raises(KeyboardInterrupt):
            loading()
        assert done
        assert signal.getsignal(number) is signal.default_int_handler
    finally:
        signal.signal(number, before)
